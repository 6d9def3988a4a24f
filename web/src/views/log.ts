//! A log that a person drops on the page, identified and drawn.

import { type IdentifiedLog, keepBlob, keepText, type LogColumns, type VerdictOutcome } from "../api/client.ts";
import { type Chart, recordCharts } from "../charts/record.ts";
import type { Span } from "../charts/strip.ts";
import { element, fill } from "../element.ts";
import { Complaints } from "../notice.ts";
import { shown, significant, withInterval } from "../units.ts";
import { causes, explained, percent, signOf, toneOf, word } from "../words.ts";
import { type Inspected, inspectedParts, isShareOf } from "./inspected.ts";
import { type Remark, remarks } from "./remarks.ts";
import { type Models, modelsPanel } from "./models.ts";
import { readingForm, windowsForm, type WindowsForm } from "./reading.ts";

type Pair = readonly [number, number];

interface LogVerdict {
  readonly outcome: VerdictOutcome;
  readonly reasons: readonly Remark[];
}

/** What is read here of the document `seatrial.identification.v1`. */
interface Identification {
  readonly samples_used?: number;
  readonly training: { readonly from_s: number; readonly to_s: number } | null;
  readonly online: { readonly a22_per_s: number; readonly b2_per_s2: number; readonly c0_rad_per_s2: number } | null;
  readonly refined: {
    readonly method: string;
    readonly a22_per_s: number;
    readonly b2_per_s2: number;
    readonly c0_rad_per_s2: number;
    readonly interval_95: { readonly a22_per_s: Pair; readonly b2_per_s2: Pair; readonly c0_rad_per_s2: Pair };
  } | null;
  readonly nomoto: { readonly t_s: number | null; readonly k_per_s: number | null } | null;
  readonly validation: {
    readonly r2_heading: number | null;
    readonly r2_heading_offset_refit: number | null;
    readonly r2_yaw_rate: number | null;
    readonly window?: { readonly from_s: number; readonly to_s: number };
  } | null;
  readonly verdict: LogVerdict;
}

interface Document extends Identification {
  readonly source: {
    readonly format: string;
    readonly samples_read: number;
    readonly rudder_unit?: string;
    readonly warnings?: readonly string[];
  };
  readonly models?: readonly {
    readonly thrust: number | null;
    readonly surge_speed_m_s: number | null;
    readonly identification: Identification | null;
    readonly verdict: LogVerdict;
  }[];
}

/** Who reads and identifies logs: a server, or this page. */
export interface LogReader {
  /** `reading` are options of `seatrial identify` by name. */
  identify(log: File, reading: Readonly<Record<string, string>>): Promise<IdentifiedLog>;
  /** What is in a log, before it is identified. */
  inspect(log: File, reading: Readonly<Record<string, string>>): Promise<Inspected>;
  columnsOf(log: File): Promise<LogColumns>;
  /** The page of `seatrial report`. */
  report(log: File, reading: Readonly<Record<string, string>>): Promise<Blob>;
  /** The track of a log that has latitude and longitude. */
  track(log: File, reading: Readonly<Record<string, string>>, format: "gpx" | "kml"): Promise<Blob>;
  /** What is made of the model of an identified log. */
  models(origin: string, document: IdentifiedLog["document"]): Models;
  /** Files that are not made here. */
  readonly without?: readonly string[];
  /** Takes a list of sensors, which logs of Slocum gliders need beside them. */
  takeSensorList(list: File): Promise<void>;
  /** Formats that a person may drop; absent where no log is asked for. */
  readonly formats?: string;
  /** Where it is done, and who sees it. */
  readonly place: string;
}

export interface LogView {
  readonly root: HTMLElement;
  /** Identifies a log as if it had been dropped and looked at. */
  open(log: File): Promise<void>;
  drop(): void;
}

export function openLogView(reader: LogReader): LogView {
  const complaints = new Complaints();
  const place = element("div", { "aria-live": "polite" });
  const charts: Chart[] = [];
  let last: File | undefined;
  const how = readingForm(() => void preview(last));
  const windows = windowsForm(() => void open(last));
  const begin = (log: File, words: string): void => {
    if (log !== last) windows.clear();
    last = log;
    fill(place, element("p", {}, words));
    for (const chart of charts.splice(0)) chart.drop();
  };
  const inspect = (log: File): Promise<Inspected | null> => complaints.hear(() => reader.inspect(log, how.reading()));
  /** Shows what is in a log. Nothing is identified yet. */
  const preview = async (log: File | undefined): Promise<void> => {
    if (log === undefined) return;
    begin(log, `Looking at ${log.name} …`);
    const found = await inspect(log);
    how.root.open ||= found === null;
    how.allow(await reader.columnsOf(log).catch(() => null));
    fill(place, found && previewPanel(log.name, found, charts, () => void open(log)));
  };
  const open = async (log: File | undefined): Promise<void> => {
    if (log === undefined) return;
    begin(log, `Identifying ${log.name} …`);
    const reading = { ...how.reading(), ...windows.reading() };
    const found = await complaints.hear(() => reader.identify(log, reading));
    how.root.open ||= found === null;
    how.allow(await reader.columnsOf(log).catch(() => null));
    if (found === null) return fill(place);
    const channels = element("details", { class: "panel" }, element("summary", {}, "What is in the log"));
    channels.addEventListener(
      "toggle",
      () => void inspect(log).then((what) => what && channels.append(...inspectedParts(what))),
      { once: true },
    );
    const keep = async (suffix: string, made: () => Promise<Blob>): Promise<void> => {
      const file = await complaints.hear(made);
      if (file !== null) keepBlob(file, `${stemOf(log.name)}.${suffix}`);
    };
    const save = (name: string, suffix: string, made: () => Promise<Blob>): HTMLElement =>
      element("button", { type: "button", onclick: () => void keep(suffix, made) }, name);
    const files = [
      save("Report, HTML", "html", () => reader.report(log, reading)),
      ...(found.is_located
        ? (["gpx", "kml"] as const).map((format) =>
            save(`Track, ${format.toUpperCase()}`, format, () => reader.track(log, reading, format)),
          )
        : []),
    ];
    fill(place, ...drawLog(log.name, found, charts, windows, files, handedOn(reader, log.name, found)), channels);
  };
  const isList = (file: File): boolean => file.name.toLowerCase().endsWith(".cac");
  /** A log, and the lists of sensors that one of a Slocum glider needs: these first. */
  const take = async (files: FileList | null | undefined): Promise<void> => {
    const chosen = [...(files ?? [])];
    for (const list of chosen.filter(isList))
      if ((await complaints.hear(() => reader.takeSensorList(list).then(() => true))) === null) return;
    await preview(chosen.find((file) => !isList(file)) ?? last);
  };
  const button = element("input", {
    class: "unseen",
    type: "file",
    multiple: true,
    onchange: () => void take(button.files),
  });
  const zone = element(
    "section",
    { class: "drop", "aria-label": "Open a log" },
    element("p", {}, element("b", {}, "Drop a log here"), `: ${reader.formats ?? ""}`),
    element("label", { class: "file" }, "Choose a file", button),
    element(
      "p",
      { class: "hint" },
      `${reader.place} A Slocum log needs its list of sensors (.cac): choose both together.`,
    ),
  );
  const over =
    (is: boolean) =>
    (event: DragEvent): void => {
      event.preventDefault();
      zone.classList.toggle("over", is);
    };
  zone.addEventListener("dragover", over(true));
  zone.addEventListener("dragleave", over(false));
  zone.addEventListener("drop", (event) => {
    over(false)(event);
    void take(event.dataTransfer?.files);
  });
  return {
    root: element(
      "div",
      { class: "stack" },
      reader.formats === undefined ? null : zone,
      how.root,
      complaints.root,
      place,
    ),
    open,
    drop: () => charts.forEach((chart) => chart.drop()),
  };
}

const stemOf = (name: string): string => name.replace(/\.\w+$/, "");

/** The natural first step: what is in the log, and how it is read. */
function previewPanel(name: string, found: Inspected, charts: Chart[], identify: () => void): HTMLElement {
  const drawn = recordCharts(found.series, [], isShareOf(found.document.source));
  charts.push(...drawn);
  return element(
    "section",
    { class: "panel stack", "aria-label": "Preview" },
    element("h2", {}, `${name}: is this what you recorded?`),
    element(
      "div",
      { class: "row" },
      element("button", { class: "main", type: "button", onclick: identify }, "Identify"),
      element("p", { class: "hint" }, "Change columns and units above where they are wrong."),
    ),
    element(
      "div",
      { class: "panels" },
      element("div", { class: "stack" }, ...drawn.map((chart) => chart.figure)),
      element("div", { class: "stack" }, ...inspectedParts(found)),
    ),
  );
}

/** Gains, limits and files of a log that has a model. */
function handedOn(reader: LogReader, name: string, found: IdentifiedLog): HTMLElement | null {
  const document = found.document as unknown as Document;
  const models = document.models ?? [];
  const hasModel = document.refined ?? document.online ?? models.find((one) => one.verdict.outcome !== "do_not_use");
  if (!hasModel) return null;
  return modelsPanel(reader.models(name, found.document), {
    stem: stemOf(name),
    isLog: true,
    isAgainst: document.verdict.outcome === "do_not_use",
    meanSpeed_m_s: models.length > 0 ? null : meanSpeed(found.series, document.training),
    ...(reader.without === undefined ? {} : { without: reader.without }),
  });
}

/** The mean forward speed over a part of a record, m/s, to a thousandth; null where none was measured. */
function meanSpeed(series: IdentifiedLog["series"], part: Identification["training"]): number | null {
  const speeds = series.surge_speed_m_s.filter((speed, at): speed is number => {
    const time_s = series.time_s[at] ?? null;
    return speed !== null && time_s !== null && part !== null && time_s >= part.from_s && time_s < part.to_s;
  });
  const sum = speeds.reduce((total, speed) => total + speed, 0);
  return speeds.length === 0 || sum <= 0 ? null : Math.round((1000 * sum) / speeds.length) / 1000;
}

function drawLog(
  name: string,
  found: IdentifiedLog,
  charts: Chart[],
  windows: WindowsForm,
  files: readonly HTMLElement[],
  next: HTMLElement | null,
): HTMLElement[] {
  const document = found.document as unknown as Document;
  const { series } = found;
  const { verdict, validation } = document;
  const model = document.refined ?? document.online;
  const facts: [string, string][] = [
    ["a₂₂, 1/s", withInterval(model?.a22_per_s, document.refined?.interval_95.a22_per_s)],
    ["b₂, 1/s²", withInterval(model?.b2_per_s2, document.refined?.interval_95.b2_per_s2)],
    ["C₀, rad/s²", withInterval(model?.c0_rad_per_s2, document.refined?.interval_95.c0_rad_per_s2)],
    ["Nomoto T, K", `${shown(document.nomoto?.t_s, "time")}, ${significant(document.nomoto?.k_per_s ?? NaN)} 1/s`],
    ["R² of heading", significant(explained(validation).r2 ?? NaN)],
    ["samples", `${document.source.samples_read} read as ${document.source.format}`],
  ];
  const { training } = document;
  const spans: Span[] = [];
  if (training) spans.push({ ...training, shade: "train" });
  if (validation?.window) spans.push({ ...validation.window, shade: "validate" });
  windows.propose(training, validation?.window ?? null);
  const isUsable = verdict.outcome !== "do_not_use";
  const drawn = recordCharts(series, spans, isShareOf(document.source), windows.drag);
  charts.push(...drawn);
  return [
    element(
      "section",
      { class: `notice ${toneOf(verdict.outcome)}` },
      element("p", { class: "loud" }, `${name}: ${signOf(verdict.outcome)} ${word(verdict.outcome)}`),
      ...causes({ ...found.verdict, other_causes: 0 }).map((text) => element("p", {}, text)),
      remarks(found.verdict, verdict.reasons),
      ...(document.source.warnings ?? []).map((warning) => element("p", { class: "hint" }, warning)),
    ),
    element(
      "div",
      { class: "panels" },
      element(
        "div",
        { class: "column" },
        element(
          "section",
          { class: "panel stack" },
          element("h2", {}, "Model"),
          isUsable ? null : element("p", {}, "A model that is not to be used has no numbers here."),
          element(
            "dl",
            { class: "facts" },
            ...(isUsable ? facts : facts.slice(-1)).flatMap(([term, value]) => [
              element("dt", {}, term),
              element("dd", {}, value),
            ]),
          ),
          speedsTable(document),
          element("div", { class: "row" }, ...files, isUsable && keepModel(name, found)),
        ),
        next,
      ),
      element(
        "section",
        { class: "panel stack" },
        element("h2", {}, "Record"),
        ...drawn.map((chart) => chart.figure),
        windows.root,
      ),
    ),
  ];
}

/** The model as a file. */
function keepModel(name: string, found: IdentifiedLog): HTMLElement {
  const file = `${stemOf(name)}.model.json`;
  const keep = (): void => keepText(`${JSON.stringify(found.document, null, 2)}\n`, file);
  return element("button", { type: "button", onclick: keep }, "Model, JSON");
}

function speedsTable(document: Document): HTMLElement | null {
  const models = document.models ?? [];
  if (models.length < 2) return null;
  const rows = models.map((one) => {
    const model = one.identification?.refined ?? one.identification?.online;
    const { outcome } = one.verdict;
    return element(
      "tr",
      {},
      element(
        "th",
        { scope: "row" },
        one.thrust === null
          ? shown(one.surge_speed_m_s, "speed")
          : `${percent(one.thrust)}, ${shown(one.surge_speed_m_s, "speed")}`,
      ),
      element("td", {}, significant((outcome === "do_not_use" ? null : model?.a22_per_s) ?? NaN)),
      element("td", {}, significant((outcome === "do_not_use" ? null : model?.b2_per_s2) ?? NaN)),
      element("td", { class: toneOf(outcome) }, `${signOf(outcome)} ${word(outcome)}`),
    );
  });
  const heads = ["speed", "a₂₂, 1/s", "b₂, 1/s²", "verdict"].map((name) => element("th", { scope: "col" }, name));
  return element(
    "div",
    { class: "table-box", tabindex: 0, role: "region", "aria-label": "Every speed of the log" },
    element("table", {}, element("thead", {}, element("tr", {}, ...heads)), element("tbody", {}, ...rows)),
  );
}
