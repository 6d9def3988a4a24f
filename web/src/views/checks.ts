//! What must be so before a vehicle is taken.

import type { Preflight } from "../api/client.ts";
import { element } from "../element.ts";

/** The checks, each with a sign for those who do not see colours. */
export function checklist(checks: Preflight["checks"]): HTMLElement {
  const items = checks.map((check) =>
    element(
      "li",
      { class: check.passed ? "good" : "bad" },
      element("span", { class: "sign" }, check.passed ? "✓" : "✗"),
      element("span", {}, element("b", {}, check.name), ` ${check.text}`),
    ),
  );
  return element("ul", { class: "checklist" }, ...items);
}
