//! The strips of a record: heading with its simulation, rudder, yaw rate.

import type { Series } from "../api/client.ts";
import { shown } from "../units.ts";
import { type Span, Strip } from "./strip.ts";

/** `isShare`: the rudder is a fraction of full, not an angle. */
export function recordStrips(
  series: Series,
  spans: readonly Span[],
  isShare: boolean,
  dragged?: (from_s: number, to_s: number) => void,
): Strip[] {
  const drags = dragged === undefined ? {} : { dragged };
  const heading = new Strip({
    title: "Heading",
    quantity: "angle",
    isTall: true,
    ...drags,
    curves: [
      { name: "measured", ink: "a" },
      { name: "simulated on validation data", ink: "b", dash: "dashed" },
    ],
  });
  const rudder = new Strip({
    title: "Rudder",
    quantity: isShare ? "share" : "angle",
    curves: [{ name: "", ink: "c" }],
    ...drags,
  });
  const rate = new Strip({ title: "Yaw rate", quantity: "angular_rate", curves: [{ name: "", ink: "a" }], ...drags });
  const seconds = series.time_s.map((at) => at ?? 0);
  heading.set(seconds, [series.heading_rad, series.simulated_heading_rad], spans);
  rudder.set(seconds, [series.rudder], spans);
  rate.set(seconds, [series.yaw_rate_rad_s], spans);
  heading.describe(`Measured and simulated heading over ${shown((seconds.at(-1) ?? 0) - (seconds[0] ?? 0), "time")}.`);
  return [heading, rudder, rate];
}
