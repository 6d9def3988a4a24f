//! The charts of a record: heading with its simulation, rudder, yaw rate where it was measured, the track where positions are known.

import type { Series } from "../api/client.ts";
import { shown } from "../units.ts";
import { type Span, Strip } from "./strip.ts";
import { type Place, Track } from "./track.ts";

/** What is drawn, and dropped with its view. */
export interface Chart {
  readonly figure: HTMLElement;
  drop(): void;
}

/** `isShare`: the rudder is a fraction of full, not an angle. */
export function recordCharts(
  series: Series,
  spans: readonly Span[],
  isShare: boolean,
  dragged?: (from_s: number, to_s: number) => void,
): Chart[] {
  const isSimulated = series.simulated_heading_rad.some((heading) => heading !== null);
  const drags = dragged === undefined ? {} : { dragged };
  const heading = new Strip({
    title: "Heading",
    quantity: "angle",
    isTall: true,
    ...drags,
    curves: [
      { name: isSimulated ? "measured" : "", ink: "a" },
      { name: isSimulated ? "simulated on validation data" : "", ink: "b", dash: "dashed" },
    ],
  });
  const rudder = new Strip({
    title: "Rudder",
    quantity: isShare ? "share" : "angle",
    curves: [{ name: "", ink: "c" }],
    ...drags,
  });
  const seconds = series.time_s.map((at) => at ?? 0);
  heading.set(seconds, [series.heading_rad, series.simulated_heading_rad], spans);
  rudder.set(seconds, [series.rudder], spans);
  heading.describe(`Measured and simulated heading over ${shown((seconds.at(-1) ?? 0) - (seconds[0] ?? 0), "time")}.`);
  const charts: Chart[] = [heading, rudder];
  if (series.yaw_rate_rad_s.some((rate) => rate !== null)) {
    const rate = new Strip({ title: "Yaw rate", quantity: "angular_rate", curves: [{ name: "", ink: "a" }], ...drags });
    rate.set(seconds, [series.yaw_rate_rad_s], spans);
    charts.push(rate);
  }
  const track = trackOf(series);
  return track === null ? charts : [...charts, track];
}

/** The way over ground, to scale; null where no two positions are known. */
function trackOf(series: Series): Track | null {
  const places = series.north_m.flatMap((north, at): Place[] => {
    const east = series.east_m[at] ?? null;
    return north === null || east === null ? [] : [[north, east]];
  });
  if (places.length < 2) return null;
  const track = new Track("Track, north up, to scale");
  track.set({ track: places, area: null, heading_rad: series.heading_rad.filter((at) => at !== null).at(-1) ?? null });
  return track;
}
