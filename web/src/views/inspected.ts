//! What a log holds: its channels, its first rows, and the manoeuvres in it.

import type { Series } from "../api/client.ts";
import { element } from "../element.ts";
import { type Quantity, scale, shown } from "../units.ts";

/** What is read here of the document `seatrial.inspection.v1`. */
export interface Inspection {
  readonly source: {
    readonly rudder_unit?: string;
    readonly warnings?: readonly string[];
    readonly format: string;
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

export interface Inspected {
  readonly document: Inspection;
  readonly series: Series;
}

/** Rows of a preview, and decimals of their numbers. */
const FIRST = 6;
const DECIMALS = 3;

/** Is the rudder a fraction of full, not an angle? */
export const isShareOf = (source: { readonly rudder_unit?: string }): boolean =>
  source.rudder_unit !== undefined && source.rudder_unit !== "rad";

export function inspectedParts({ document, series }: Inspected): HTMLElement[] {
  const { source, sampling, manoeuvres } = document;
  const rate = sampling.rate_hz === null ? "" : ` at ${sampling.rate_hz.toPrecision(3)} Hz`;
  const isShare = isShareOf(source);
  const gaps = sampling.gaps === 1 ? "1 gap" : `${sampling.gaps} gaps`;
  return [
    element("p", {}, `${sampling.samples} samples${rate}, ${gaps}, read as ${source.format}.`),
    ...(source.warnings ?? []).map((warning) => element("p", { class: "hint" }, warning)),
    table(
      "Channels",
      ["quantity", "column", "unit", "taken because"],
      source.channels.map((channel) => [
        channel.quantity.replaceAll("_", " "),
        channel.column,
        channel.unit,
        channel.because ?? "its name says so",
      ]),
    ),
    firstRows(series, isShare),
    manoeuvres.length === 0
      ? element("p", {}, "No doublet, zig-zag or turning circle was recognised: the whole log is used.")
      : table(
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

/** The first rows as they are read, in the units of the page. */
function firstRows(series: Series, isShare: boolean): HTMLElement {
  const all: readonly (readonly [string, readonly (number | null)[], Quantity])[] = [
    ["time", series.time_s, "time"],
    ["heading", series.heading_rad, "angle"],
    ["rudder", series.rudder, isShare ? "share" : "angle"],
    ["speed", series.surge_speed_m_s, "speed"],
    ["yaw rate", series.yaw_rate_rad_s, "angular_rate"],
    ["north", series.north_m, "distance"],
    ["east", series.east_m, "distance"],
  ];
  const columns = all.filter(([, values]) => values.some((value) => value !== null));
  const rows = series.time_s.slice(0, FIRST).map((_, at) =>
    columns.map(([, values, quantity]) => {
      const value = values[at] ?? null;
      return value === null ? "–" : `${+(value * scale(quantity).factor).toFixed(DECIMALS)}`.replace("-", "−");
    }),
  );
  return table(
    "First rows as read",
    columns.map(([name, , quantity]) => `${name}, ${scale(quantity).unit}`),
    rows,
  );
}

/** What stands in a cell; two texts are a value and its interval, which stands below it. */
export type Cell = string | readonly [value: string, interval: string];

export function table(name: string, heads: readonly string[], rows: readonly (readonly Cell[])[]): HTMLElement {
  const cell = (of: Cell): HTMLElement => {
    const [value, interval] = typeof of === "string" ? [of, null] : of;
    return element("td", {}, value, interval && element("span", { class: "interval" }, interval));
  };
  const cells = rows.map((row) => element("tr", {}, ...row.map(cell)));
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
