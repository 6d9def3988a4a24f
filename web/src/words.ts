//! What is going on, in plain words.

import type { RunSummary, Stage, TrialState, Verdict, VerdictOutcome } from "./api/client.ts";
import type { Live } from "./api/live.ts";
import { clock, type Quantity, significant } from "./units.ts";

export type Tone = "plain" | "good" | "partly" | "bad";

export interface Said {
  readonly tone: Tone;
  readonly loud: string;
  readonly details: readonly string[];
}

export const STAGES: readonly [Stage, string][] = [
  ["settle", "Settle"],
  ["train", "Train"],
  ["validate", "Validate"],
];

const DOING: Record<Stage, string> = {
  settle: "Settling: waiting for steady heading, rate and depth",
  train: "Training: the doublet teaches the model",
  validate: "Validating: a second doublet tests the model",
};

export const LIMITS: Record<string, string> = {
  depth: "depth",
  altitude: "altitude",
  roll: "roll",
  pitch: "pitch",
  yaw_rate: "yaw rate",
  heading_excursion: "heading",
  area: "area",
  speed_drift: "speed drift",
  stale_samples: "silence",
  stage_time_limit: "stage time",
};

interface Quantified {
  readonly name: string;
  readonly quantity: Quantity;
  /** Of a plain quantity. */
  readonly unit?: string;
}

export const QUANTITIES: Record<string, Quantified> = {
  a22_per_s: { name: "a₂₂", quantity: "plain", unit: "1/s" },
  b2_per_s2: { name: "b₂", quantity: "plain", unit: "1/s²" },
  c0_rad_per_s2: { name: "C₀", quantity: "plain", unit: "rad/s²" },
  delta0_rad: { name: "δ₀", quantity: "angle" },
  proportional_gain: { name: "Kₚ", quantity: "plain" },
  steady_turning_radius_starboard_m: { name: "radius to starboard", quantity: "distance" },
  steady_turning_radius_port_m: { name: "radius to port", quantity: "distance" },
};

export const percent = (fraction: number): string => `${+(100 * fraction).toPrecision(3)}\u00a0%`;

export function situation(live: Live): Said {
  const { trial } = live;
  if (live.connection === "refused")
    return { tone: "bad", loud: "The server wants a token", details: [live.refusal ?? ""] };
  if (live.commission?.running === true)
    return {
      tone: "partly",
      loud: "Heading steps move the boat",
      details: ["They are shown under Gains. ABORT ends them and puts the old gains back."],
    };
  if (trial === null)
    return live.connection === "open"
      ? { tone: "plain", loud: "No trial is running", details: [] }
      : { tone: "plain", loud: "Looking for the server", details: [] };
  return trial.running ? underWay(trial) : ended(trial);
}

function underWay(trial: TrialState): Said {
  const { progress, estimate } = trial;
  const last = trial.runs.at(-1);
  const details: string[] = [];
  if (estimate && progress?.stage === "train") {
    details.push(
      estimate.converged_s === null || estimate.converged_s === undefined
        ? "The estimate still moves."
        : `The estimate converged ${significant(estimate.converged_s)} s into training.`,
    );
  }
  if (last !== undefined) details.push(verdict(last));
  if (!progress?.stage) return { tone: "plain", loud: "The trial begins", details };
  const again = progress.attempt > 1 ? `, attempt ${progress.attempt}` : "";
  return {
    tone: "plain",
    loud: `${DOING[progress.stage]}. Speed ${progress.speed} of ${progress.speeds}, ${percent(progress.thrust)} thrust${again}`,
    details,
  };
}

function ended(trial: TrialState): Said {
  const thrusts = new Set(planned(trial));
  const accepted = new Set(trial.runs.filter(isUsable).map((run) => run.thrust));
  const isWhole = accepted.size === thrusts.size;
  const have = accepted.size === 1 ? "has" : "have";
  const count = isWhole ? [] : [`${accepted.size} of ${thrusts.size} speeds ${have} a usable model.`];
  const handedBack = trial.warnings.length === 0 ? ["The rudder is neutral and the vehicle is handed back."] : [];
  const of = trial.verdict ?? null;
  const judged = of === null ? [] : [`${signOf(of.outcome)} ${sentence(word(of.outcome))}`, ...causes(of)];
  const details = [...judged, ...count, ...handedBack, ...trial.warnings];
  if (trial.outcome?.finished === true)
    return { tone: of === null ? "partly" : toneOf(of.outcome), loud: "The trial is finished", details };
  return { tone: "bad", loud: `The trial ended early: ${trial.outcome?.text ?? "it met a fault"}`, details };
}

export function verdict(run: RunSummary): string {
  return [judged(run), ...causes(run.verdict)].join(" ");
}

function judged(run: RunSummary): string {
  const who = run.review ? ` (${reviewed(run.review)}: ${run.review.note})` : "";
  return `Run ${run.number} at ${percent(run.thrust)} thrust: ${word(run.verdict.outcome)}${who}.`;
}

/** Has the run a model that may be used, as its campaign sees it? */
export const isUsable = ({ accepted, verdict: of }: RunSummary): boolean => accepted && of.outcome !== "do_not_use";

/** What an operator decided. */
export function reviewed(review: NonNullable<RunSummary["review"]>): string {
  return `${review.accepted ? "accepted" : "rejected"} by ${review.by}`;
}

/** The four outcomes: their words, their tones and their signs. */
const OUTCOMES: Record<VerdictOutcome, readonly [word: string, tone: Tone, sign: string]> = {
  use: ["use", "good", "✓"],
  use_with_care: ["use with care", "partly", "!"],
  not_validated: ["not validated", "partly", "!"],
  do_not_use: ["do not use", "bad", "✗"],
};

export const word = (outcome: VerdictOutcome): string => OUTCOMES[outcome][0];
export const toneOf = (outcome: VerdictOutcome): Tone => OUTCOMES[outcome][1];
export const signOf = (outcome: VerdictOutcome): string => OUTCOMES[outcome][2];

/** The cause of an outcome and what to do about it. */
export function causes(verdict: Verdict): string[] {
  const { cause, other_causes: others, promises = [] } = verdict;
  const advice = cause ? [sentence(cause.text), ...(cause.action === "" ? [] : [cause.action])] : [];
  const lines = [...promises, ...advice];
  if (others === 0) return lines;
  return [...lines, others === 1 ? "There is 1 more remark." : `There are ${others} more remarks.`];
}

type Validated =
  { readonly r2_heading?: number | null; readonly r2_heading_offset_refit?: number | null } | null | undefined;

/** R² of heading on validation data; with the offset estimated again where it drifted and the model explains more so. */
export function explained(model: Validated): { readonly r2: number | null; readonly isOffsetAgain: boolean } {
  const [plain, again] = [model?.r2_heading ?? null, model?.r2_heading_offset_refit ?? null];
  const isOffsetAgain = plain !== null && again !== null ? again > Math.max(plain, 0) + 0.05 : again !== null;
  return { r2: isOffsetAgain ? again : plain, isOffsetAgain };
}

/** A text with a large first letter and a full stop. */
export function sentence(text: string): string {
  // Names of files, vehicles and parameters stay as they are.
  const isWord = /^[a-z]{2,}[,;:]?(\s|$)/.test(text);
  const begun = isWord ? text.charAt(0).toUpperCase() + text.slice(1) : text;
  return /[.!?]$/.test(begun) ? begun : `${begun}.`;
}

/** The thrusts of the plan in its order. */
export function planned(trial: TrialState): number[] {
  const thrusts: unknown = (trial.plan as Record<string, unknown>)["thrusts"];
  return Array.isArray(thrusts) ? thrusts.filter((thrust): thrust is number => typeof thrust === "number") : [];
}

/** What a screen reader is told as it happens. */
export function news(live: Live): string {
  const { trial } = live;
  if (trial === null) return "";
  if (!trial.running) return situation(live).loud;
  const stage = STAGES.find(([name]) => name === trial.progress?.stage)?.[1];
  const last = trial.runs.at(-1);
  const result = last === undefined ? "" : `Run ${last.number}: ${word(last.verdict.outcome)}. `;
  return stage === undefined
    ? result
    : `${result}${stage}, speed ${trial.progress?.speed} of ${trial.progress?.speeds}, at most ${clock((trial.progress?.elapsed_s ?? 0) + (trial.progress?.remaining_s ?? 0))}.`;
}
