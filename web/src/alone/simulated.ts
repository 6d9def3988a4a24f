//! A simulated trial with sliders: what the numbers of a verdict mean, where the truth is known.

import { keepText } from "../api/client.ts";
import { element, fill } from "../element.ts";
import { Complaints } from "../notice.ts";
import { significant } from "../units.ts";
import { openLogView, type LogView } from "../views/log.ts";
import { table } from "../views/inspected.ts";
import type { Program } from "./module.ts";
import { readerOf } from "./own.ts";

interface Played {
  readonly log: string;
  readonly csv: string;
  readonly truth: { readonly a22_per_s: number; readonly b2_per_s2: number; readonly c0_rad_per_s2: number } | null;
}

interface Model {
  readonly refined: {
    readonly interval_95: Record<string, readonly [number, number]>;
  } | null;
}

/** Name, label, least, most, step, at the beginning, factor to the unit of the module. */
const SLIDERS = [
  ["thrust", "Thrust, % of full", 60, 100, 5, 80, 0.01],
  ["compass_noise_rad", "Compass noise, °", 0, 3, 0.1, 0.3, Math.PI / 180],
  ["rudder_rad", "Rudder of the doublet, °", 2, 14.5, 0.5, 14.5, Math.PI / 180],
  ["current_m_s", "Current across the course, m/s", 0, 0.6, 0.05, 0, 1],
  ["seed", "Noise of sea number", 1, 20, 1, 1, 1],
] as const;

export function openSimulated(program: Program): LogView {
  const { formats: _, ...unasked } = readerOf(program);
  const view = openLogView(unasked);
  const complaints = new Complaints();
  const truth = element("section", { class: "panel stack", "aria-label": "Against the truth" });
  const sliders = SLIDERS.map(([name, label, min, max, step, value, factor]) => {
    const input = element("input", { type: "range", name, min, max, step, value });
    const shown = element("output", {}, String(value));
    input.addEventListener("input", () => (shown.textContent = input.value));
    const field = element("label", { class: "field" }, element("span", {}, `${label}: `, shown), input);
    return { name, field, value: () => Number(input.value) * factor };
  });
  const play = async (): Promise<void> => {
    const { current_m_s, ...stated } = Object.fromEntries(sliders.map(({ name, value }) => [name, value()]));
    const trial = { vehicle: { six_degrees_of_freedom: { current_m_s } }, ...stated };
    const played = await complaints.hear(() => program.ask<Played>({ ask: "simulate", trial }));
    if (played === null) return;
    const log = new File([played.csv], played.log);
    await view.open(log);
    const found = await program.ask<{ document: Model }>({ ask: "identify", log: played.log }).catch(() => null);
    fill(truth, ...against(played, found?.document ?? null));
  };
  const form = element(
    "form",
    { class: "panel stack", onsubmit: (event: Event) => (event.preventDefault(), void play()) },
    element("h2", {}, "A trial of the paper's vehicle in six degrees of freedom"),
    element(
      "p",
      { class: "hint" },
      "The vehicle settles, lays its rudder to both sides once, and once more for validation. What it measures is identified below, as a log of your own would be.",
    ),
    element("div", { class: "fields" }, ...sliders.map(({ field }) => field)),
    element("div", { class: "row" }, element("button", { class: "main", type: "submit" }, "Run the trial")),
    complaints.root,
  );
  return { ...view, root: element("div", { class: "stack" }, form, truth, view.root) };
}

function against(played: Played, found: Model | null): HTMLElement[] {
  const { truth } = played;
  const rows = (["a22_per_s", "b2_per_s2", "c0_rad_per_s2"] as const).map((name) => {
    const interval = found?.refined?.interval_95[name];
    const value = truth?.[name];
    const holds = interval !== undefined && value !== undefined && interval[0] <= value && value <= interval[1];
    return [
      name.split("_")[0] ?? name,
      significant(value ?? NaN),
      interval === undefined ? "no model" : `${significant(interval[0])} to ${significant(interval[1])}`,
      interval === undefined ? "–" : holds ? "✓ holds the truth" : "✗ misses it",
    ];
  });
  return [
    element("h2", {}, "Against the truth"),
    table("Truth and 95 % intervals", ["parameter", "truth", "interval found", ""], rows),
    element(
      "p",
      { class: "hint" },
      "Of twenty such intervals one may miss. More noise and less rudder widen them, until the verdict says that the record does not tell.",
    ),
    element(
      "div",
      { class: "row" },
      element("button", { type: "button", onclick: () => keepText(played.csv, played.log) }, "The log, CSV"),
    ),
  ];
}
