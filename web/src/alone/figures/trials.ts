//! Simulated trials that a figure shows, played again where a slider moves.

import { Refused } from "../../api/client.ts";
import type { Program } from "../module.ts";

export interface Trial {
  readonly vehicle: { readonly first_order: { readonly rudder_lag_s: number } };
  readonly thrust: number;
  readonly compass_noise_rad: number;
  readonly rudder_rad: number;
  readonly seed: number;
}

interface Parameters {
  readonly a22_per_s: number;
}

/** The truth of a trial, and what is read here of the document `seatrial.identification.v1`. */
export interface Found {
  readonly truth: Parameters | null;
  readonly document: {
    readonly online: Parameters | null;
    readonly refined: (Parameters & { readonly interval_95: { readonly a22_per_s: readonly [number, number] } }) | null;
    readonly verdict: { readonly outcome: string };
  };
}

/** The paper's vehicle at 80 % thrust, as the first-order model that is looked for. */
export function trial(noiseDeg: number, rudderDeg: number, lagS: number, seed: number): Trial {
  return {
    vehicle: { first_order: { rudder_lag_s: lagS } },
    thrust: 0.8,
    compass_noise_rad: (noiseDeg * Math.PI) / 180,
    rudder_rad: (rudderDeg * Math.PI) / 180,
    seed,
  };
}

/** Plays and identifies trials one by one, and begins anew where others are asked for meanwhile. */
export class Trials {
  readonly #program: Program;
  #wanted: { readonly trials: readonly Trial[]; readonly show: (found: readonly (Found | null)[]) => void } | null =
    null;
  #isBusy = false;

  constructor(program: Program) {
    this.#program = program;
  }

  /** Shows what was found so far, after every trial; null where the log gave no model. */
  play(trials: readonly Trial[], show: (found: readonly (Found | null)[]) => void): void {
    this.#wanted = { trials, show };
    if (!this.#isBusy) void this.#work();
  }

  async #work(): Promise<void> {
    this.#isBusy = true;
    while (this.#wanted !== null) {
      const now = this.#wanted;
      const found: (Found | null)[] = [];
      for (const trial of now.trials) {
        const one = await this.#found(trial);
        if (one === undefined) {
          this.#wanted = null;
          break;
        }
        found.push(one);
        if (this.#wanted !== now) break;
        now.show(found);
      }
      if (this.#wanted === now) this.#wanted = null;
    }
    this.#isBusy = false;
  }

  /** Null where the log gives no model; undefined where the program does not run. */
  async #found(trial: Trial): Promise<Found | null | undefined> {
    try {
      return await this.#program.ask<Found>({ ask: "rehearse", trial });
    } catch (error) {
      return error instanceof Refused && error.code === "refused" ? null : undefined;
    }
  }
}
