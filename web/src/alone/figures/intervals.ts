//! Why intervals: twenty trials that differ in their noise alone, and whether their intervals hold the truth.

import { withInterval } from "../../units.ts";
import type { Drawn, Mark } from "./drawing.ts";
import { type Found, trial, type Trial } from "./trials.ts";
import type { FigureOf } from "./figure.ts";

const TRIALS = 20;

export const intervals: FigureOf = {
  name: "Twenty trials and their intervals",
  sliders: [
    { name: "noise", label: "Compass noise, °", min: 0.1, max: 3, step: 0.1, value: 1 },
    { name: "rudder", label: "Rudder of the doublet, °", min: 2, max: 14.5, step: 0.5, value: 8 },
  ],
  trials: ([noise = 0, rudder = 0]): Trial[] =>
    Array.from({ length: TRIALS }, (_, at) => trial(noise, rudder, 0, at + 1)),
  drawn: (found): Drawn => {
    const marks = found.flatMap((one, at): Mark[] => {
      const refined = one?.document.refined;
      if (!refined) return [];
      const interval = refined.interval_95.a22_per_s;
      return [{ x: at + 1, value: refined.a22_per_s, interval, ink: holds(one) ? "a" : "b" }];
    });
    const truth = found.find((one) => one !== null)?.truth?.a22_per_s ?? NaN;
    return {
      across: { from: 0, to: TRIALS + 1, ticks: [1, 5, 10, 15, 20], label: "trial" },
      up: {
        from: -2.2,
        to: 0,
        ticks: [-2, -1.5, -1, -0.5, 0],
        label: "a₂₂, 1/s, its 95 % interval, and the truth (dashed)",
      },
      truth,
      marks,
      keys: [
        ["a", false, "holds the truth"],
        ["b", false, "misses it"],
      ],
      words: said(found),
    };
  },
  said,
};

function holds({ truth, document }: Found): boolean {
  const [low, high] = document.refined?.interval_95.a22_per_s ?? [NaN, NaN];
  return truth !== null && low <= truth.a22_per_s && truth.a22_per_s <= high;
}

function said(found: readonly (Found | null)[]): string {
  const models = found.filter((one): one is Found => one?.document.refined != null);
  const holding = models.filter(holds).length;
  const unused = models.filter(({ document }) => document.verdict.outcome === "do_not_use").length;
  const first = models[0]?.document.refined;
  const none = found.length - models.length;
  return [
    `${holding} of ${models.length} intervals hold the truth.`,
    first == null ? "" : `The first: a₂₂ = ${withInterval(first.a22_per_s, first.interval_95.a22_per_s)} 1/s.`,
    unused > 0 ? `The verdict on ${unused} of them is: do not use.` : "",
    none > 0 ? `${none} ${none === 1 ? "trial" : "trials"} gave no model.` : "",
  ]
    .filter((text) => text !== "")
    .join(" ");
}
