//! A log that a person drops on the page, identified and drawn.

import { type IdentifiedLog, keepText, type VerdictOutcome } from "../api/client.ts";
import { recordStrips } from "../charts/record.ts";
import type { Span, Strip } from "../charts/strip.ts";
import { element, fill } from "../element.ts";
import { Complaints } from "../notice.ts";
import { shown, significant, withInterval } from "../units.ts";
import { causes, explained, percent, sentence, signOf, toneOf, word } from "../words.ts";
import { readingForm, windowsForm, type WindowsForm } from "./reading.ts";

type Pair = readonly [number, number];

interface Remark {
  readonly code: string;
  readonly text: string;
  readonly action: string;
}

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
  columnsOf(log: File): Promise<string[]>;
  /** Takes a list of sensors, which logs of Slocum gliders need beside them. */
  takeSensorList(list: File): Promise<void>;
  /** Formats that a person may drop; absent where no log is asked for. */
  readonly formats?: string;
  /** Where it is done, and who sees it. */
  readonly place: string;
  /** What is shown below the model, of a log that was read; `found` is null where it was refused. */
  below?(log: File, reading: Readonly<Record<string, string>>, found: IdentifiedLog | null): HTMLElement;
}

export interface LogView {
  readonly root: HTMLElement;
  /** Opens a log as if it had been dropped. */
  open(log: File): Promise<void>;
  drop(): void;
}

export function openLogView(reader: LogReader): LogView {
  const complaints = new Complaints();
  const place = element("div", { "aria-live": "polite" });
  const charts: Strip[] = [];
  let last: File | undefined;
  const how = readingForm(() => void open(last));
  const windows = windowsForm(() => void open(last));
  const open = async (log: File | undefined): Promise<void> => {
    if (log === undefined) return;
    if (log !== last) windows.clear();
    last = log;
    const reading = { ...how.reading(), ...windows.reading() };
    fill(place, element("p", {}, `Reading ${log.name} …`));
    for (const chart of charts.splice(0)) chart.drop();
    const found = await complaints.hear(() => reader.identify(log, reading));
    how.root.open ||= found === null;
    how.allow(await reader.columnsOf(log).catch(() => []));
    fill(
      place,
      ...(found === null ? [] : drawLog(log.name, found, charts, windows, reader.below === undefined)),
      reader.below?.(log, reading, found),
    );
  };
  const isList = (file: File): boolean => file.name.toLowerCase().endsWith(".cac");
  /** A log, and the lists of sensors that one of a Slocum glider needs: these first. */
  const take = async (files: FileList | null | undefined): Promise<void> => {
    const chosen = [...(files ?? [])];
    for (const list of chosen.filter(isList))
      if ((await complaints.hear(() => reader.takeSensorList(list).then(() => true))) === null) return;
    await open(chosen.find((file) => !isList(file)) ?? last);
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

function drawLog(
  name: string,
  found: IdentifiedLog,
  charts: Strip[],
  windows: WindowsForm,
  hasTerminal: boolean,
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
  const isShare = document.source.rudder_unit !== undefined && document.source.rudder_unit !== "rad";
  const strips = recordStrips(series, spans, isShare, windows.drag);
  charts.push(...strips);
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
        isUsable && keepModel(name, found, hasTerminal),
      ),
      element(
        "section",
        { class: "panel stack" },
        element("h2", {}, "Record"),
        ...strips.map((strip) => strip.figure),
        windows.root,
      ),
    ),
  ];
}

/** What else is to be said of a model, behind a fold. */
function remarks(verdict: IdentifiedLog["verdict"], reasons: readonly Remark[]): HTMLElement | null {
  const shown = ["ok", "sign_reversed", verdict.cause?.code];
  const others = reasons.filter((reason) => !shown.includes(reason.code));
  if (others.length === 0) return null;
  const said = others.map(({ text, action }) => element("li", {}, `${sentence(text)} ${action}`));
  const count = others.length === 1 ? "1 more remark" : `${others.length} more remarks`;
  return element("details", {}, element("summary", {}, count), element("ul", {}, ...said));
}

/** The model as a file, and what makes gains of it. */
function keepModel(name: string, found: IdentifiedLog, hasTerminal: boolean): HTMLElement {
  const file = `${name.replace(/\.\w+$/, "")}.model.json`;
  const keep = (): void => keepText(`${JSON.stringify(found.document, null, 2)}\n`, file);
  return element(
    "div",
    { class: "stack" },
    element("div", { class: "row" }, element("button", { type: "button", onclick: keep }, "Model, JSON")),
    hasTerminal && element("p", { class: "hint" }, "Gains and limits of it, in a terminal:"),
    hasTerminal && element("pre", { tabindex: 0 }, `seatrial gains --model ${file}`),
  );
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
