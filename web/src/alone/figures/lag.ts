//! How a lag fools you: the same vehicle behind servos of every lag, taken for one without and identified with it.

import { significant, withInterval } from "../../units.ts";
import type { Drawn, Mark } from "./drawing.ts";
import type { FigureOf } from "./figure.ts";
import { type Found, trial, type Trial } from "./trials.ts";

/** Of the servo, s. */
const LAGS_S = [0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4];

export const lag: FigureOf = {
  name: "A lag that nobody knows of",
  sliders: [
    { name: "lag", label: "Lag of the rudder, s", min: 0, max: 0.4, step: 0.05, value: 0.15 },
    { name: "noise", label: "Compass noise, °", min: 0.1, max: 1, step: 0.1, value: 0.1 },
  ],
  trials: ([, noise = 0]): Trial[] => LAGS_S.map((lagS) => trial(noise, 14.5, lagS, 1)),
  drawn: (found, values): Drawn => {
    const marks = found.flatMap((one, at): Mark[] => {
      const x = LAGS_S[at] ?? NaN;
      const { online = null, refined = null } = one?.document ?? {};
      const found: Mark[] = [];
      if (online !== null) found.push({ x, value: online.a22_per_s, ink: "b" });
      if (refined !== null)
        found.push({ x, value: refined.a22_per_s, interval: refined.interval_95.a22_per_s, ink: "a" });
      return found;
    });
    return {
      across: { from: -0.03, to: 0.43, ticks: [0, 0.1, 0.2, 0.3, 0.4], label: "lag of the rudder, s" },
      up: { from: -1.6, to: 0, ticks: [-1.5, -1, -0.5, 0], label: "a₂₂, 1/s, and the truth (dashed)" },
      truth: found.find((one) => one !== null)?.truth?.a22_per_s ?? NaN,
      marks,
      keys: [
        ["a", false, "with a lag allowed for"],
        ["b", true, "without"],
      ],
      chosen: values[0] ?? 0,
      words: said(found, values),
    };
  },
  said,
};

function said(found: readonly (Found | null)[], [lagS = 0]: readonly number[]): string {
  const one = found[LAGS_S.findIndex((own) => Math.abs(own - lagS) < 1e-9)];
  if (!one) return "";
  const { online, refined } = one.document;
  const share = online === null || one.truth === null ? NaN : online.a22_per_s / one.truth.a22_per_s - 1;
  const off = `${Math.abs(100 * share).toFixed(0)} % ${share < 0 ? "too little" : "too much"}`;
  return [
    `Truth ${significant(one.truth?.a22_per_s ?? NaN)} 1/s.`,
    online === null ? "" : `The command taken for the rudder: ${significant(online.a22_per_s)}, ${off} damping.`,
    refined === null
      ? "With a lag allowed for: no model."
      : `With a lag allowed for: ${withInterval(refined.a22_per_s, refined.interval_95.a22_per_s)}.`,
  ]
    .filter((text) => text !== "")
    .join(" ");
}
