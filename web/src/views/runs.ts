//! Runs of a campaign, with the operator's word on each.

import { type Figure, goOn, repeatSpeed, reviewRun, type RunSummary, seriesOf } from "../api/client.ts";
import { type Chart, recordCharts } from "../charts/record.ts";
import { element, fill } from "../element.ts";
import { Complaints } from "../notice.ts";
import { bounded, shown, significant } from "../units.ts";
import { remarks } from "./remarks.ts";
import { explained, percent, reviewed, signOf, toneOf, verdict, word } from "../words.ts";

/** A value over its interval. */
export function figureCell(figure: Figure | null | undefined, factor = 1): HTMLElement {
  const [low, high] = figure?.interval_95 ?? [];
  if (!figure || low === undefined || high === undefined)
    return element("td", {}, figure ? significant(figure.value * factor) : "–");
  const [value, from, to] = bounded(figure.value * factor, low * factor, high * factor);
  return element("td", {}, value, element("span", { class: "interval" }, `[${from}, ${to}]`));
}

function r2Cell(run: RunSummary): HTMLElement {
  const { r2, isOffsetAgain } = explained(run.model);
  return element(
    "td",
    {},
    significant(r2 ?? NaN),
    isOffsetAgain && element("span", { class: "interval" }, "offset again"),
  );
}

/** Where runs are from. */
export interface Origin {
  readonly campaign: number;
  /** Only a simulated vehicle has one. */
  readonly seed?: number | null | undefined;
}

const isSimulated = ({ seed }: Origin): boolean => typeof seed === "number";

/** The pace of another trial on the same vehicle: a real one has its own. */
export const paceAgain = (origin: Origin): number | null => (isSimulated(origin) ? 1 : null);

/** A button that starts another trial on the same vehicle. One that is not simulated is agreed to first. */
function again(origin: Origin, name: string, kind: string, start: (agreed: boolean) => void): readonly HTMLElement[] {
  const agreed = element("input", { type: "checkbox" });
  const button = element("button", { class: kind, type: "button", onclick: () => start(agreed.checked) }, name);
  if (isSimulated(origin)) return [button];
  button.disabled = true;
  agreed.addEventListener("change", () => (button.disabled = !agreed.checked));
  return [element("label", { class: "choice" }, agreed, "I agree that the vehicle moves again"), button];
}

/** What is left of a campaign that ended early. */
export function resume(origin: Origin, complaints: Complaints): HTMLElement {
  const start = async (agreed: boolean): Promise<void> => {
    const { campaign } = origin;
    const started = await complaints.hear(() => goOn({ campaign, realtime_factor: paceAgain(origin), agreed }));
    if (started !== null) location.hash = "#/live";
  };
  const said = isSimulated(origin) ? " The vehicle is simulated: nothing moves." : "";
  return element(
    "div",
    { class: "notice partly stack" },
    element("p", {}, `It ended early. What is left of its plan can be done as a campaign of its own.${said}`),
    element(
      "div",
      { class: "row" },
      ...again(origin, "Go on at the next speed", "main", (agreed) => void start(agreed)),
    ),
  );
}

/** The runs as a table; `changed` is called after a review or a repeat. */
export function runsTable(
  origin: Origin,
  runs: readonly RunSummary[],
  changed: () => void,
): { root: HTMLElement; drop(): void } {
  const desk = new Desk(origin, changed);
  const rows = runs.map((run) => {
    const title = `run ${run.number}`;
    return element(
      "tr",
      {},
      element("th", { scope: "row" }, `${run.number}`),
      element("td", {}, percent(run.thrust)),
      element("td", {}, shown(run.surge_speed_m_s, "speed")),
      element(
        "td",
        { class: `words ${toneOf(run.verdict.outcome)}` },
        `${signOf(run.verdict.outcome)} ${word(run.verdict.outcome)}${run.review ? `, ${reviewed(run.review)}` : ""}`,
      ),
      element(
        "td",
        { class: "words" },
        element(
          "button",
          { type: "button", "aria-label": `Review ${title}`, onclick: () => desk.open(run) },
          "Review …",
        ),
      ),
      figureCell(run.model?.a22_per_s),
      figureCell(run.model?.b2_per_s2),
      figureCell(run.model?.c0_rad_per_s2),
      r2Cell(run),
    );
  });
  // The verdict stands before the numbers: a phone shows it without a sideways scroll.
  const words = ["verdict", "review"];
  const numbers = ["a₂₂, 1/s", "b₂, 1/s²", "C₀, rad/s²", "R²"];
  const heads = ["run", "thrust", "speed", ...words, ...numbers].map((name) =>
    element("th", { scope: "col", class: words.includes(name) ? "words" : "" }, name),
  );
  const root = element(
    "div",
    { class: "stack" },
    element(
      "div",
      { class: "table-box", tabindex: 0, role: "region", "aria-label": "Runs" },
      element("table", {}, element("thead", {}, element("tr", {}, ...heads)), element("tbody", {}, ...rows)),
    ),
    desk.root,
  );
  return { root, drop: () => desk.close() };
}

/** Where one run is looked at and judged. */
class Desk {
  readonly root = element("div", {});
  private charts: Chart[] = [];

  constructor(
    private readonly origin: Origin,
    private readonly changed: () => void,
  ) {}

  close(): void {
    for (const chart of this.charts.splice(0)) chart.drop();
    fill(this.root);
  }

  open(run: RunSummary): void {
    this.close();
    const { origin, changed } = this;
    const { campaign } = origin;
    const complaints = new Complaints();
    const record = element("div", { class: "stack" });
    const note = element("textarea", { rows: 2, maxlength: 4000, required: true });
    note.value = run.review?.note ?? "";
    const review = async (accepted: boolean): Promise<void> => {
      if (!form.reportValidity()) return;
      if ((await complaints.hear(() => reviewRun(campaign, run.number, accepted, note.value))) === null) return;
      this.close();
      changed();
    };
    const repeat = async (agreed: boolean): Promise<void> => {
      const started = await complaints.hear(() =>
        repeatSpeed({ campaign, thrust: run.thrust, realtime_factor: paceAgain(origin), agreed }),
      );
      if (started !== null) location.hash = "#/live";
    };
    const form = element(
      "form",
      { class: "notice stack", onsubmit: (event: Event) => event.preventDefault() },
      element("h3", {}, `Run ${run.number}, ${percent(run.thrust)} thrust`),
      element("p", {}, verdict({ ...run, verdict: { ...run.verdict, other_causes: 0 } })),
      remarks(run.verdict, run.reasons),
      run.model
        ? element(
            "p",
            { class: "hint" },
            `Nomoto T = ${shown(run.model.nomoto_t_s, "time")}, K = ${significant(run.model.nomoto_k_per_s ?? NaN)} 1/s. Method: ${run.model.method.replaceAll("_", " ")}.`,
          )
        : null,
      record,
      element("label", { class: "field" }, "Note: why?", note),
      complaints.root,
      element(
        "div",
        { class: "row" },
        element(
          "button",
          { type: "button", disabled: !run.model, onclick: () => void review(true) },
          "✓ Accept this run",
        ),
        element("button", { type: "button", onclick: () => void review(false) }, "✗ Reject this run"),
        ...again(origin, "Repeat this speed now", "", (agreed) => void repeat(agreed)),
        element("button", { type: "button", onclick: () => this.close() }, "Close"),
      ),
    );
    fill(this.root, form);
    note.focus();
    void complaints
      .hear(() => seriesOf(campaign, run.number))
      .then((series) => {
        if (series === null || !form.isConnected) return;
        this.charts = recordCharts(
          series,
          run.stages.map(({ stage, from_s, to_s }) => ({
            shade: stage,
            from_s,
            to_s: to_s ?? series.time_s.at(-1) ?? from_s,
          })),
          false,
        );
        fill(record, ...this.charts.map((chart) => chart.figure));
      });
  }
}
