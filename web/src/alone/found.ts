//! What a log holds: its channels, and the manoeuvres in it.

import { element } from "../element.ts";
import { shown } from "../units.ts";
import type { Program } from "./module.ts";

/** What is read here of the document `seatrial.inspection.v1`. */
interface Inspection {
  readonly source: {
    readonly rudder_unit?: string;
    readonly channels: readonly {
      readonly quantity: string;
      readonly column: string;
      readonly unit: string;
      readonly because: string | null;
    }[];
  };
  readonly sampling: { readonly samples: number; readonly rate_hz: number | null; readonly gaps: number };
  readonly manoeuvres: readonly {
    readonly kind: string;
    readonly from_s: number;
    readonly to_s: number;
    readonly amplitude_rad: number;
    readonly surge_speed_m_s: number | null;
  }[];
}

/** Nothing of a log that cannot be read: why is said above. */
export async function found(program: Program, request: object): Promise<HTMLElement[]> {
  const answer = await program
    .ask<{ document: Inspection }>({ ask: "inspect", ...request })
    .catch((): { document: Inspection } | null => null);
  if (answer === null) return [];
  const { source, sampling, manoeuvres } = answer.document;
  const rate = sampling.rate_hz === null ? "" : ` at ${sampling.rate_hz.toPrecision(3)} Hz`;
  const isShare = source.rudder_unit !== undefined && source.rudder_unit !== "rad";
  return [
    element("h2", {}, "What is in the log"),
    element("p", {}, `${sampling.samples} samples${rate}, ${sampling.gaps} gaps.`),
    table(
      "Channels",
      ["quantity", "column", "unit", "taken because"],
      source.channels.map((channel) => [
        channel.quantity,
        channel.column,
        channel.unit,
        channel.because ?? "it says so",
      ]),
    ),
    table(
      "Manoeuvres",
      ["manoeuvre", "from", "to", "rudder", "speed"],
      manoeuvres.map((one) => [
        one.kind.replaceAll("_", " "),
        shown(one.from_s, "time", 5),
        shown(one.to_s, "time", 5),
        shown(one.amplitude_rad, isShare ? "share" : "angle"),
        shown(one.surge_speed_m_s, "speed"),
      ]),
    ),
  ];
}

export function table(name: string, heads: readonly string[], rows: readonly (readonly string[])[]): HTMLElement {
  const cells = rows.map((row) => element("tr", {}, ...row.map((cell) => element("td", {}, cell))));
  return element(
    "div",
    { class: "table-box", tabindex: 0, role: "region", "aria-label": name },
    element(
      "table",
      {},
      element("caption", {}, rows.length === 0 ? `${name}: none` : name),
      element("thead", {}, element("tr", {}, ...heads.map((head) => element("th", { scope: "col" }, head)))),
      element("tbody", {}, ...cells),
    ),
  );
}
