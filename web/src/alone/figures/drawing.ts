//! A drawing of estimates beside the truth. It bears its own style, so that the same drawing stands in a page and in a file.

import { fill, svg } from "../../element.ts";

const WIDTH = 420;
const HEIGHT = 268;
const [LEFT, RIGHT, TOP, BOTTOM] = [46, 10, 24, 56];

/** Colours of the page where it has them, else those of paper. */
const STYLE = `
text { font: 13px system-ui, -apple-system, "Segoe UI", Roboto, "Liberation Sans", sans-serif; fill: var(--ink, #16202a); }
.ground { fill: var(--paper, #ffffff); }
.grid { stroke: var(--grid, #dde3e8); stroke-width: 1; }
.truth { stroke: var(--ink, #16202a); stroke-width: 1.5; stroke-dasharray: 6 4; }
.interval { stroke-width: 3; stroke-linecap: round; }
.a { stroke: var(--a, #0b6e99); fill: var(--a, #0b6e99); }
.b { stroke: var(--b, #b3491a); fill: var(--b, #b3491a); }
.cross { stroke-width: 2.5; fill: none; }
.chosen { fill: var(--grid, #dde3e8); }
.middle { text-anchor: middle; }
.end { text-anchor: end; }
`;

export interface Axis {
  readonly from: number;
  readonly to: number;
  readonly ticks: readonly number[];
  readonly label: string;
}

/** What is drawn at a place across: an interval with its estimate, or an estimate alone as a cross. */
export interface Mark {
  readonly x: number;
  readonly value: number;
  readonly interval?: readonly [number, number] | undefined;
  readonly ink: "a" | "b";
}

export interface Drawn {
  readonly across: Axis;
  readonly up: Axis;
  readonly truth: number;
  readonly marks: readonly Mark[];
  /** What the inks stand for. */
  readonly keys: readonly (readonly [ink: "a" | "b", isCross: boolean, label: string])[];
  /** A place across that is shaded. */
  readonly chosen?: number;
  /** For who does not see it. */
  readonly words: string;
}

export function emptyDrawing(): SVGSVGElement {
  return svg("svg", { xmlns: "http://www.w3.org/2000/svg", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img" });
}

export function draw(into: SVGSVGElement, { across, up, truth, marks, keys, chosen, words }: Drawn): void {
  const x = (value: number): number => at(value, across, LEFT, WIDTH - RIGHT);
  // What lies outside ends at the edge.
  const y = (value: number): number => at(Math.min(Math.max(value, up.from), up.to), up, HEIGHT - BOTTOM, TOP);
  const line = (name: string, x1: number, y1: number, x2: number, y2: number): SVGElement =>
    svg("line", { class: name, x1: round(x1), y1: round(y1), x2: round(x2), y2: round(y2) });
  const cross = (ink: string, cx: number, cy: number, data = {}): SVGElement => {
    const r = 4;
    const d = `M${round(cx - r)} ${round(cy - r)}l${2 * r} ${2 * r}m0 ${-2 * r}l${-2 * r} ${2 * r}`;
    return svg("path", { class: `cross ${ink}`, d, ...data });
  };
  const dot = (cx: number, cy: number): SVGElement => svg("circle", { cx: round(cx), cy: round(cy), r: 3.5 });
  const bar = (mark: Mark, [low, high]: readonly [number, number]): SVGElement =>
    svg(
      "g",
      { class: mark.ink, "data-value": mark.value, "data-low": low, "data-high": high },
      line("interval", x(mark.x), y(low), x(mark.x), y(high)),
      dot(x(mark.x), y(mark.value)),
    );
  const key = (ink: string, isCross: boolean, label: string, at: number): SVGElement[] => [
    isCross ? cross(ink, at, HEIGHT - 10) : svg("g", { class: ink }, dot(at, HEIGHT - 10)),
    svg("text", { x: at + 9, y: HEIGHT - 6 }, label),
  ];
  into.setAttribute("aria-label", words);
  fill(
    into,
    svg("style", {}, STYLE),
    svg("rect", { class: "ground", width: WIDTH, height: HEIGHT }),
    chosen !== undefined &&
      svg("rect", { class: "chosen", x: round(x(chosen) - 10), y: TOP, width: 20, height: HEIGHT - BOTTOM - TOP }),
    ...up.ticks.flatMap((tick) => [
      line("grid", LEFT, y(tick), WIDTH - RIGHT, y(tick)),
      svg("text", { class: "end", x: LEFT - 6, y: round(y(tick) + 4) }, shownTick(tick)),
    ]),
    ...across.ticks.map((tick) =>
      svg("text", { class: "middle", x: round(x(tick)), y: HEIGHT - BOTTOM + 17 }, shownTick(tick)),
    ),
    svg("text", { class: "middle", x: (LEFT + WIDTH - RIGHT) / 2, y: HEIGHT - BOTTOM + 34 }, across.label),
    svg("text", { x: 6, y: 13 }, up.label),
    ...keys.flatMap(([ink, isCross, label], at) => key(ink, isCross, label, LEFT + 6 + at * 190)),
    ...marks.map((mark) =>
      mark.interval === undefined
        ? cross(mark.ink, x(mark.x), y(mark.value), { "data-value": mark.value })
        : bar(mark, mark.interval),
    ),
    Number.isFinite(truth) && line("truth", LEFT, y(truth), WIDTH - RIGHT, y(truth)),
  );
}

/** The drawing as a file. */
export function asFile(drawing: SVGSVGElement): string {
  return `${new XMLSerializer().serializeToString(drawing)}\n`;
}

function at(value: number, axis: Axis, from: number, to: number): number {
  return from + ((value - axis.from) / (axis.to - axis.from)) * (to - from);
}

function round(value: number): number {
  return Math.round(10 * value) / 10;
}

function shownTick(tick: number): string {
  return String(tick).replace("-", "−");
}
