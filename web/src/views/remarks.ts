//! What else is said of a model or a trial, behind a fold.

import type { Verdict } from "../api/client.ts";
import { element } from "../element.ts";
import { sentence } from "../words.ts";

export interface Remark {
  readonly code: string;
  readonly of?: string | null;
  readonly text: string;
  readonly action: string;
}

/** Reasons beside the cause, which is said already. */
export function remarks(verdict: Verdict, reasons: readonly Remark[]): HTMLElement | null {
  const kind = (reason?: Remark | null) => `${reason?.code} ${reason?.of ?? ""}`;
  const shown = ["ok ", "sign_reversed rudder", kind(verdict.cause)];
  const others = reasons.filter((reason) => !shown.includes(kind(reason)));
  if (others.length === 0) return null;
  const said = others.map(({ text, action }) => element("li", {}, `${sentence(text)} ${action}`));
  const count = others.length === 1 ? "1 more remark" : `${others.length} more remarks`;
  return element("details", {}, element("summary", {}, count), element("ul", {}, ...said));
}
