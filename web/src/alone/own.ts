//! A log of one's own, read and identified in the page.

import type { IdentifiedLog } from "../api/client.ts";
import { type LogReader, openLogView, type LogView } from "../views/log.ts";
import type { Inspected } from "../views/inspected.ts";
import type { Limits, Models } from "../views/models.ts";
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
  const asked = async <T>(ask: string, log: File, reading: Reading): Promise<T> => {
    await program.hold(log);
    return program.ask<T>({ ask, log: log.name, reading: typed(reading) });
  };
  return {
    identify: async (log, reading) => {
      // `document` is the terminal's, `shown` the same in the words of this page.
      const { shown, columns: _, ...found } = await asked<Identified>("identify", log, reading);
      return { ...found, document: shown };
    },
    inspect: (log, reading) => asked<Inspected>("inspect", log, reading),
    columnsOf: async (log) => {
      await program.hold(log);
      return program.ask({ ask: "columns", log: log.name });
    },
    report: async (log, reading) => {
      const { html } = await asked<{ html: string }>("report", log, reading);
      return new Blob([html], { type: "text/html" });
    },
    track: async (log, reading, format) => {
      await program.hold(log);
      const request = { ask: "track", log: log.name, reading: typed(reading), kml: format === "kml" };
      return new Blob([(await program.ask<{ text: string }>(request)).text]);
    },
    models: (origin, document): Models => ({
      limits: (stated) => program.ask<Limits>({ ask: "gains", origin, document, stated }),
      file: async (form, stated) => {
        const request = { ask: "file", origin, document, stated, form };
        const { text, notes } = await program.ask<{ text: string; notes: string[] }>(request);
        return { blob: new Blob([text]), notes };
      },
    }),
    without: ["fmu"],
    takeSensorList: (list) => program.hold(list),
    formats:
      "CSV, Parquet, DataFlash .bin, telemetry .tlog, ULog, MCAP, ROS 1 .bag, Excel .xlsx, MATLAB .mat, NMEA 0183, NMEA 2000, Signal K, Expedition, MOOS .alog, Slocum .dbd, DUNE .lsf, …",
    place: "It is read and identified in this page, is sent nowhere, and the page works without a network.",
  };
}

export function openOwnLog(program: Program): LogView {
  return openLogView(readerOf(program));
}
