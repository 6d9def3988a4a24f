//! Two values with their intervals on one scale.

import type { Figure } from "../api/client.ts";
import { svg } from "../element.ts";

const WIDTH = 120;
const HEIGHT = 26;
const MARGIN = 6;

export function pair(a: Figure, b: Figure): SVGSVGElement {
  const ends = [a, b].flatMap((figure) => [figure.value, ...(figure.interval_95 ?? [])]);
  const [low, high] = [Math.min(...ends), Math.max(...ends)];
  const x = (value: number): number =>
    high > low ? MARGIN + ((value - low) / (high - low)) * (WIDTH - 2 * MARGIN) : WIDTH / 2;
  const drawn = (figure: Figure, ink: string, y: number): SVGElement[] => {
    const [from = figure.value, to = figure.value] = figure.interval_95 ?? [];
    return [
      svg("path", { class: ink, d: `M${x(from)} ${y - 4}v8m0-4H${x(to)}m0-4v8` }),
      svg("circle", { class: ink, cx: x(figure.value), cy: y, r: 3 }),
    ];
  };
  return svg(
    "svg",
    { class: "pair", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, "aria-hidden": "true" },
    ...drawn(a, "ink-a", 7),
    ...drawn(b, "ink-b", 19),
  );
}
