//! A log of one's own, read and identified in the page.

import { type IdentifiedLog, keepText } from "../api/client.ts";
import { element, fill } from "../element.ts";
import { Complaints } from "../notice.ts";
import { type LogReader, openLogView, type LogView } from "../views/log.ts";
import { found } from "./found.ts";
import { controllers } from "./controllers.ts";
import type { Program } from "./module.ts";

type Reading = Readonly<Record<string, string>>;

type Identified = IdentifiedLog & { readonly shown: IdentifiedLog["document"]; readonly columns: string[] };

/** Fields of a reading that are numbers. */
const NUMBERS = /^(from_s|to_s|validate_from_s|validate_to_s|rudder_\w+)$/;

/** What the form says, as the module takes it. */
export function typed(reading: Reading): Record<string, string | number | boolean> {
  const of = (name: string, value: string): string | number | boolean =>
    name === "drop_invalid" ? value === "true" : NUMBERS.test(name) ? Number(value) : value;
  return Object.fromEntries(Object.entries(reading).map(([name, value]) => [name, of(name, value)]));
}

/** Reads logs with the module of this page. */
export function readerOf(program: Program): LogReader {
  let known: { readonly log: File; readonly columns: string[] } | null = null;
  return {
    identify: async (log, reading) => {
      await program.hold(log);
      const request = { ask: "identify", log: log.name, reading: typed(reading) };
      // `document` is the terminal's, `shown` the same in the words of this page.
      const { shown, columns, ...found } = await program.ask<Identified>(request);
      known = { log, columns };
      return { ...found, document: shown };
    },
    columnsOf: async (log) =>
      known?.log === log
        ? known.columns
        : (await program.ask<{ columns: string[] }>({ ask: "columns", log: log.name })).columns,
    takeSensorList: (list) => program.hold(list),
    formats:
      "CSV, Parquet, DataFlash .bin, ULog, tlog, MCAP, rosbag2 .db3, ROS 1 .bag, Excel .xlsx, MATLAB .mat, NMEA 0183, NMEA 2000, Expedition, MOOS .alog, Slocum .dbd",
    place: "It is read and identified in this page, is sent nowhere, and the page works without a network.",
    below: (log, reading, identified) => below(program, log, reading, identified),
  };
}

export function openOwnLog(program: Program): LogView {
  return openLogView(readerOf(program));
}

function below(program: Program, log: File, reading: Reading, identified: IdentifiedLog | null): HTMLElement {
  const request = { log: log.name, reading: typed(reading) };
  const complaints = new Complaints();
  const report = async (): Promise<void> => {
    const page = await complaints.hear(() => program.ask<{ html: string }>({ ask: "report", ...request }));
    if (page !== null) keepText(page.html, `${log.name.replace(/\.\w+$/, "")}.html`);
  };
  const channels = element("section", { class: "panel stack", "aria-label": "What is in the log" });
  void found(program, request).then((what) => fill(channels, ...what));
  return element(
    "div",
    { class: "stack spaced" },
    identified !== null &&
      element(
        "div",
        { class: "row" },
        element("button", { type: "button", onclick: () => void report() }, "Report, HTML"),
      ),
    complaints.root,
    identified !== null && identified.verdict.outcome !== "do_not_use"
      ? controllers(program, log.name, identified)
      : null,
    channels,
  );
}
