//! What the vehicle is doing and how sure we are.

import type { Figure, RunSummary, TrialState } from "../api/client.ts";
import type { Live } from "../api/live.ts";
import { Gauge } from "../charts/gauge.ts";
import { type Column, type Span, Strip } from "../charts/strip.ts";
import { Track } from "../charts/track.ts";
import { element, fill, say } from "../element.ts";
import type { View } from "../shell.ts";
import { afterTrial, startPanel } from "./start.ts";
import { clock, shown, significant, withInterval } from "../units.ts";
import { explained, isUsable, LIMITS, percent, planned, signOf, situation, STAGES, word } from "../words.ts";

const REDRAW_MS = 100;
const CALM_REDRAW_MS = 500;
/** Intervals that were so many times as wide as the latest are cut. */
const MOST_WIDTHS = 8;

type Parameter = "a22_per_s" | "b2_per_s2" | "c0_rad_per_s2";
const PARAMETERS: readonly [Parameter, string, string][] = [
  ["a22_per_s", "Damping a₂₂", "1/s"],
  ["b2_per_s2", "Rudder effect b₂", "1/s²"],
  ["c0_rad_per_s2", "Disturbance C₀", "rad/s²"],
];

export function openLive(live: Live): View {
  const notice = element("section", { class: "notice", "aria-label": "What is going on" });
  const speeds = element("ol", { class: "speeds", "aria-label": "Speeds of the plan" });
  const stages = stageTimeline();
  const motion = [
    new Strip({
      title: "Heading",
      quantity: "angle",
      leastSpan: 0.5,
      isSteady: true,
      curves: [
        { name: "measured", ink: "a" },
        { name: "simulated", ink: "b", dash: "dashed" },
      ],
    }),
    new Strip({
      title: "Yaw rate",
      quantity: "angular_rate",
      leastSpan: 0.2,
      isSteady: true,
      curves: [{ name: "", ink: "a" }],
    }),
    new Strip({ title: "Rudder", quantity: "angle", leastSpan: 0.5, isSteady: true, curves: [{ name: "", ink: "c" }] }),
  ] as const;
  const estimates = PARAMETERS.map(
    ([, title, unit]) =>
      new Strip({
        title,
        quantity: "plain",
        unit,
        curves: [
          { name: "95 % interval", ink: "d", dash: "dotted" },
          { name: "", ink: "d", dash: "dotted" },
          { name: "estimate", ink: "b" },
        ],
        band: [0, 1],
      }),
  );
  const stepNorm = new Strip({
    title: "Step of the estimate",
    quantity: "plain",
    unit: "logarithmic",
    logarithmic: true,
    curves: [
      { name: "step norm", ink: "a" },
      { name: "converged below", ink: "ink", dash: "dashed" },
    ],
  });
  const validation = new Strip({
    title: "Validation: heading",
    quantity: "angle",
    leastSpan: 0.05,
    curves: [
      { name: "measured", ink: "a" },
      { name: "simulated with the model", ink: "b", dash: "dashed" },
    ],
  });
  const track = new Track("Track");
  const gauges = element("div", { class: "gauges" });
  const gaugeOf = new Map<string, Gauge>();
  const link = element("dl", { class: "facts" });
  const sure = element("p", { class: "hint" });
  const outcome = element("p", { class: "hint" });
  const start = startPanel();
  const after = afterTrial(live);
  const numbers = numbersNow();

  const progress = element(
    "section",
    { class: "panel spaced", "aria-label": "Progress" },
    speeds,
    stages.root,
    numbers.root,
  );
  const charts = element(
    "div",
    { class: "panels spaced" },
    element(
      "div",
      { class: "column" },
      element(
        "section",
        { class: "panel stack" },
        element("h2", {}, "What it does"),
        ...motion.map((strip) => strip.figure),
      ),
      element(
        "section",
        { class: "panel stack" },
        element("h2", {}, "Does the model predict?"),
        outcome,
        validation.figure,
      ),
    ),
    element(
      "div",
      { class: "column" },
      element(
        "section",
        { class: "panel stack" },
        element("h2", {}, "How sure we are"),
        sure,
        ...estimates.map((strip) => strip.figure),
        stepNorm.figure,
      ),
    ),
    element(
      "div",
      { class: "column" },
      element(
        "section",
        { class: "panel stack" },
        element("h2", {}, "Where it is"),
        track.figure,
        element("h3", {}, "Limits used"),
        gauges,
      ),
      element("section", { class: "panel" }, element("h2", {}, "Link and clock"), link),
    ),
  );
  const root = element("div", {}, element("div", { class: "at-once" }, notice, after.root), start, progress, charts);

  const draw = (): void => {
    const { trial, samples } = live;
    const said = situation(live);
    notice.className = `notice ${said.tone}`;
    fill(notice, element("p", { class: "loud" }, said.loud), ...said.details.map((text) => element("p", {}, text)));
    start.hidden = trial !== null || live.connection !== "open";
    // Before there is a trial there is nothing to draw.
    progress.hidden = trial === null;
    charts.hidden = trial === null;
    after.draw();
    drawSpeeds(speeds, trial);
    stages.set(trial);
    numbers.set(live);

    const spans: Span[] = live.stages.map(({ stage, from_s, to_s }) => ({ shade: stage, from_s, to_s }));
    motion[0].set(samples.time_s, [samples.heading_rad, samples.simulated_heading_rad], spans);
    motion[1].set(samples.time_s, [samples.yaw_rate_rad_s], spans);
    motion[2].set(samples.time_s, [samples.rudder_rad], spans);
    motion[0].describe(`Heading ${shown(samples.heading_rad.at(-1), "angle")}.`);
    // A simulator of first order, and a boat without a gyro, measure none.
    motion[1].figure.hidden = samples.time_s.length > 0 && samples.yaw_rate_rad_s.every((rate) => rate === null);
    motion[1].describe(`Yaw rate ${shown(samples.yaw_rate_rad_s.at(-1), "angular_rate")}.`);
    motion[2].describe(`Rudder ${shown(samples.rudder_rad.at(-1), "angle")}.`);

    const seconds = live.estimates.map((estimate) => estimate.time_s);
    PARAMETERS.forEach(([name, title, unit], at) => {
      const figures = live.estimates.map((estimate) => estimate[name]);
      const bound = (end: 0 | 1): Column => figures.map((figure) => figure.interval_95?.[end] ?? null);
      estimates[at]?.set(seconds, [bound(1), bound(0), figures.map((figure) => figure.value)], [], frame(figures));
      const last = figures.at(-1);
      estimates[at]?.describe(`${title} ${withInterval(last?.value, last?.interval_95)} ${unit}.`);
    });
    const threshold = live.estimates.at(-1)?.threshold ?? null;
    stepNorm.set(seconds, [live.estimates.map((estimate) => estimate.step_norm), seconds.map(() => threshold)]);
    stepNorm.describe(`Step norm ${significant(live.estimates.at(-1)?.step_norm ?? NaN)}.`);
    // One estimate is no curve: as fast as a simulator can, few are shown.
    for (const strip of [...estimates, stepNorm]) strip.figure.hidden = live.estimates.length < 2;
    say(sure, sureness(trial));

    const overlay = trial?.validation;
    validation.set(overlay?.time_s ?? [], [overlay?.measured_heading_rad ?? [], overlay?.simulated_heading_rad ?? []]);
    say(outcome, predicts(trial?.runs.find((run) => run.number === overlay?.run)));
    validation.describe(outcome.textContent ?? "");

    track.set({
      track: live.track_m,
      area: (live.envelope?.area_m ?? []).map(([north = 0, east = 0]) => [north, east]),
      heading_rad: samples.heading_rad.at(-1) ?? null,
    });
    drawGauges(gauges, gaugeOf, trial);
    drawLink(link, live);
  };

  const calm = matchMedia("(prefers-reduced-motion: reduce)");
  let due = 0;
  const later = (): void => {
    due ||= window.setTimeout(
      () => {
        due = 0;
        draw();
      },
      calm.matches ? CALM_REDRAW_MS : REDRAW_MS,
    );
  };
  const unwatch = live.watch(later);
  draw();
  return {
    root,
    drop: () => {
      unwatch();
      clearTimeout(due);
      for (const chart of [...motion, ...estimates, stepNorm, validation, track]) chart.drop();
    },
  };
}

/** What is told next to the latest interval: the first estimates and intervals are off by orders of magnitude. */
function frame(figures: readonly Figure[]): [number, number] | null {
  const intervals = figures.flatMap(({ interval_95 }) => (interval_95 ? [interval_95] : []));
  const width = ([low = 0, high = 0]: readonly number[]): number => high - low;
  const latest = intervals.at(-1);
  const comparable = intervals.filter((one) => latest !== undefined && width(one) <= MOST_WIDTHS * width(latest));
  const settled = figures.slice(Math.floor(figures.length / 2)).map((figure) => figure.value);
  const seen = [...settled, ...comparable.flat()];
  if (seen.length === 0) return null;
  const [low, high] = [Math.min(...seen), Math.max(...seen)];
  const room = 0.25 * (high - low) || 0.1 * Math.abs(high) || 1e-3;
  return [low - room, high + room];
}

/** The estimate of the moment; once the run is over, that of the table of runs. */
function sureness(trial: TrialState | null): string {
  const run = trial?.runs.at(-1);
  const ended = run?.number === trial?.progress?.run ? run?.model : null;
  const estimate = ended ?? trial?.estimate;
  if (!estimate) return "The estimate begins with the training stage.";
  const converged = estimate.converged_s ?? null;
  const word = converged === null ? "Not converged yet" : `Converged after ${shown(converged, "time")}`;
  return `${word}. a₂₂ = ${withInterval(estimate.a22_per_s.value, estimate.a22_per_s.interval_95)}, b₂ = ${withInterval(estimate.b2_per_s2.value, estimate.b2_per_s2.interval_95)}.`;
}

function predicts(run: RunSummary | undefined): string {
  if (run === undefined) return "Measured and simulated heading appear here when a run has been validated.";
  const { r2, isOffsetAgain } = explained(run?.model);
  const part = r2 === null ? "an unknown part" : percent(Math.max(r2, 0));
  return `Run ${run.number}: the model explains ${part} of the heading it has not seen (R²${isOffsetAgain ? ", its offset estimated again" : ""}).`;
}

function drawSpeeds(list: HTMLElement, trial: TrialState | null): void {
  const thrusts = trial === null ? [] : planned(trial);
  list.hidden = thrusts.length === 0;
  const items = thrusts.map((thrust, at) => {
    const runs = trial?.runs.filter((run) => Math.abs(run.thrust - thrust) < 1e-9) ?? [];
    const last = runs.at(-1);
    const now = trial?.running === true && trial.progress?.speed === at + 1;
    const attempt = trial?.progress?.attempt ?? 1;
    const [state, sign, label] = now
      ? ["now", "▶", attempt === 1 ? "now" : `now, attempt ${attempt}`]
      : last === undefined
        ? ["coming", "", trial?.running === true ? "to come" : "not run"]
        : [isUsable(last) ? "accepted" : "rejected", signOf(last.verdict.outcome), word(last.verdict.outcome)];
    const item = element(
      "li",
      { class: state },
      element("b", {}, percent(thrust)),
      element("small", {}, `${sign} ${label}`),
    );
    if (now) item.setAttribute("aria-current", "step");
    return item;
  });
  if (list.textContent !== items.map((item) => item.textContent).join("")) fill(list, ...items);
}

/** What the vehicle measures now, in figures that are read from afar. */
function numbersNow(): { root: HTMLElement; set(live: Live): void } {
  const names = ["Heading", "Rudder", "Yaw rate", "Speed", "Depth"] as const;
  const values = names.map(() => element("dd", {}, "–"));
  const root = element(
    "dl",
    { class: "numbers", "aria-label": "Now" },
    ...names.map((name, at) => element("div", {}, element("dt", {}, name), values[at])),
  );
  return {
    root,
    set: ({ samples, trial }) => {
      root.hidden = trial === null;
      const heading = samples.heading_rad.at(-1);
      const turn = 2 * Math.PI;
      const compass = typeof heading === "number" ? ((heading % turn) + turn) % turn : null;
      const texts = [
        shown(compass, "angle"),
        shown(samples.rudder_rad.at(-1), "angle", 2),
        shown(samples.yaw_rate_rad_s.at(-1), "angular_rate", 2),
        shown(samples.surge_speed_m_s.at(-1), "speed"),
        shown(samples.depth_m.at(-1), "distance", 2),
      ];
      texts.forEach((text, at) => values[at] !== undefined && say(values[at], text));
    },
  };
}

function stageTimeline(): { root: HTMLElement; set(trial: TrialState | null): void } {
  const items = STAGES.map(([stage, name]) => {
    const filled = element("span", { class: "filled" });
    const countdown = element("span", { class: "countdown" });
    return {
      stage,
      filled,
      countdown,
      item: element("li", { class: stage }, filled, element("span", {}, name), countdown),
    };
  });
  const root = element("ol", { class: "stages", "aria-label": "Stages of the run" }, ...items.map(({ item }) => item));
  return {
    root,
    set(trial) {
      const progress = trial?.running === true ? (trial.progress ?? null) : null;
      const now = STAGES.findIndex(([stage]) => stage === progress?.stage);
      items.forEach(({ filled, countdown, item }, at) => {
        const elapsed = progress?.elapsed_s ?? 0;
        const length = elapsed + (progress?.remaining_s ?? 0);
        const share = at < now ? 1 : at === now && length > 0 ? Math.min(elapsed / length, 1) : 0;
        filled.style.width = `${(100 * share).toFixed(1)}%`;
        item.classList.toggle("now", at === now);
        item.classList.toggle("past", at < now);
        if (at === now) item.setAttribute("aria-current", "step");
        else item.removeAttribute("aria-current");
        say(countdown, at === now ? clock(progress?.remaining_s) : at < now ? "✓" : "");
      });
    },
  };
}

function drawGauges(place: HTMLElement, gauges: Map<string, Gauge>, trial: TrialState | null): void {
  for (const { limit, used } of trial?.envelope ?? []) {
    let gauge = gauges.get(limit);
    if (gauge === undefined) {
      gauge = new Gauge(LIMITS[limit] ?? limit);
      gauges.set(limit, gauge);
      place.append(gauge.row);
    }
    gauge.set(used);
  }
  if (gauges.size === 0) say(place, "No limit is in use.");
  else if (place.firstChild instanceof Text) place.firstChild.remove();
}

function drawLink(list: HTMLElement, live: Live): void {
  const { health, trial } = live;
  const facts: [string, string][] =
    health === null || trial?.running !== true
      ? [["vehicle", "no trial is running"]]
      : [
          [
            "last sample",
            typeof health.silent_for_s !== "number"
              ? "none yet"
              : `${health.silent_for_s < 0.1 ? "less than 0.1 s" : shown(health.silent_for_s, "time", 2)} ago`,
          ],
          [
            "time between samples",
            `${shown(health.interval_s, "time", 2)}, ${shown(health.expected_interval_s, "time", 2)} expected`,
          ],
          ["longest gap", shown(health.longest_interval_s, "time", 2)],
          [
            "vehicle's clock",
            health.clock_rate === null || health.clock_rate === undefined
              ? "not known yet"
              : `runs ${significant(health.clock_rate)} times as fast as the server's`,
          ],
          ["samples", `${health.samples}${health.not_shown === 0 ? "" : `, ${health.not_shown} not shown`}`],
        ];
  const values = [...list.querySelectorAll("dd")];
  if (values.length !== facts.length)
    fill(list, ...facts.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)]));
  else facts.forEach(([, value], at) => values[at] !== undefined && say(values[at], value));
}
