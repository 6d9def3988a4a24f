//! A strip chart over the vehicle's time, drawn with uPlot in the colours of the theme.

import uPlot from "uplot";
import { element, say } from "../element.ts";
import { onTheme, token } from "../theme.ts";
import { onUnits, type Quantity, scale } from "../units.ts";

export type Ink = "a" | "b" | "c" | "d" | "ink";
type Dash = "solid" | "dashed" | "dotted" | "dots";
export type Column = readonly (number | null)[];

export interface Curve {
  readonly name: string;
  readonly ink: Ink;
  readonly dash?: Dash;
}

/** A shaded range of the horizontal axis. */
export interface Span {
  readonly from_s: number;
  readonly to_s: number;
  readonly shade: "settle" | "train" | "validate";
}

export interface StripPlan {
  readonly title: string;
  readonly quantity: Quantity;
  /** The unit of a plain quantity, `1/s`. */
  readonly unit?: string;
  readonly curves: readonly Curve[];
  /** Two curves, upper and lower, with the interval between them shaded. */
  readonly band?: readonly [number, number];
  readonly logarithmic?: boolean;
  /** The vertical axis covers at least this much, SI, so that noise does not look like motion. */
  readonly leastSpan?: number;
  /** What the horizontal axis is where it is not time. */
  readonly across?: Quantity;
  readonly isTall?: boolean;
  /** The vertical axis grows with what is seen, and never shrinks while the same run goes on. */
  readonly isSteady?: boolean;
  /** Called with the ends of a segment of time that was dragged over. */
  readonly dragged?: (from_s: number, to_s: number) => void;
}

const DASHES: Record<Dash, number[]> = { solid: [], dashed: [9, 4], dotted: [2, 4], dots: [0, 1e6] };

export class Strip {
  readonly figure: HTMLElement;
  private readonly place = element("div", { class: "strip" });
  private readonly summary = element("span", { class: "unseen" });
  private readonly unit = element("span", { class: "unit" });
  private chart: uPlot | null = null;
  private seconds: readonly number[] = [];
  private columns: readonly Column[] = [];
  private spans: readonly Span[] = [];
  private frame: readonly [number, number] | null = null;
  private widest: [number, number] | null = null;
  private readonly undo: (() => void)[] = [];

  constructor(private readonly plan: StripPlan) {
    const legend = plan.curves
      .filter((curve) => curve.name !== "")
      .map((curve) => element("span", { class: `key key-${curve.ink} key-${curve.dash ?? "solid"}` }, curve.name));
    this.figure = element(
      "figure",
      { class: "chart" },
      element(
        "figcaption",
        {},
        element("span", { class: "title" }, plan.title, " ", this.unit),
        element("span", { class: "legend" }, ...legend),
      ),
      this.place,
      this.summary,
    );
    const resized = new ResizeObserver(() => this.fit());
    resized.observe(this.place);
    this.undo.push(
      () => resized.disconnect(),
      onTheme(() => this.rebuild()),
      onUnits(() => this.rebuild()),
    );
  }

  /** Shows columns in SI units over the vehicle's seconds; `frame` are the ends of the vertical axis, else found from the columns. */
  set(
    seconds: readonly number[],
    columns: readonly Column[],
    spans: readonly Span[] = [],
    frame: readonly [number, number] | null = null,
  ): void {
    if (seconds[0] !== this.seconds[0]) this.widest = null;
    this.seconds = seconds;
    this.columns = columns;
    this.spans = spans;
    this.frame = frame;
    if (this.chart === null) this.rebuild();
    else this.chart.setData(this.data());
  }

  /** Says in words what the chart shows, for those who do not see it. */
  describe(text: string): void {
    say(this.summary, text);
  }

  drop(): void {
    for (const undo of this.undo) undo();
    this.chart?.destroy();
    this.chart = null;
  }

  private data(): uPlot.AlignedData {
    const { factor } = scale(this.plan.quantity);
    const even =
      this.plan.logarithmic === true
        ? (v: number | null) => (v !== null && v > 0 ? v * factor : null)
        : (v: number | null) => (v === null ? null : v * factor);
    const across = scale(this.plan.across ?? "time").factor;
    return [this.seconds.map((x) => x * across), ...this.columns.map((column) => column.map(even))];
  }

  private rebuild(): void {
    const width = this.place.clientWidth;
    const over = this.plan.across === undefined ? "" : ` over ${this.plan.across}, ${scale(this.plan.across).unit}`;
    say(this.unit, `${this.plan.unit ?? scale(this.plan.quantity).unit}${over}`);
    this.chart?.destroy();
    this.chart = null;
    if (width > 0) this.chart = new uPlot(this.options(width), this.data(), this.place);
  }

  private fit(): void {
    const width = this.place.clientWidth;
    if (width === 0) return;
    if (this.chart === null) this.rebuild();
    else if (this.chart.width !== width) this.chart.setSize({ width, height: this.height() });
  }

  private height(): number {
    return (this.plan.isTall === true ? 13 : 8.2) * rootSize();
  }

  private options(width: number): uPlot.Options {
    const { factor } = scale(this.plan.quantity);
    const least = (this.plan.leastSpan ?? 0) * factor;
    const rem = rootSize();
    const axis: uPlot.Axis = {
      stroke: token("--soft"),
      font: `${0.75 * rem}px system-ui, sans-serif`,
      grid: { stroke: token("--grid"), width: 1 },
      ticks: { show: false },
    };
    const weight = Number(token("--weight"));
    const shade = token("--band");
    return {
      width,
      height: this.height(),
      legend: { show: false },
      cursor:
        this.plan.dragged === undefined
          ? { show: false }
          : { x: false, y: false, points: { show: false }, drag: { x: true, y: false, setScale: false } },
      padding: [0.4 * rem, 0.8 * rem, 0, 0],
      scales: {
        x: { time: false },
        y:
          this.plan.logarithmic === true
            ? { distr: 3 }
            : {
                range: (_chart, low, high) =>
                  this.frame === null
                    ? this.steadied(spread(low, high, least))
                    : [this.frame[0] * factor, this.frame[1] * factor],
              },
      },
      axes: [
        { ...axis, size: 1.6 * rem, values: (_chart, at) => at.map((x) => `${+x.toFixed(3)}`) },
        {
          ...axis,
          size: 3.6 * rem,
          space: 1.5 * rem,
          values: (_chart, at) => at.map((y) => (y === null ? "" : label(y))),
        },
      ],
      series: [
        {},
        ...this.plan.curves.map((curve): uPlot.Series => ({
          stroke: token(`--${curve.ink}`),
          width: weight,
          spanGaps: this.plan.band !== undefined,
          dash: DASHES[curve.dash ?? "solid"],
          points: curve.dash === "dots" ? { show: true, size: 5, fill: token(`--${curve.ink}`) } : { show: false },
        })),
      ],
      ...(this.plan.band === undefined
        ? {}
        : { bands: [{ series: [this.plan.band[0] + 1, this.plan.band[1] + 1], fill: shade }] }),
      hooks: { drawClear: [(chart) => this.shade(chart)], setSelect: [(chart) => this.take(chart)] },
    };
  }

  private steadied([low, high]: [number, number]): [number, number] {
    if (this.plan.isSteady !== true) return [low, high];
    this.widest = [Math.min(low, this.widest?.[0] ?? low), Math.max(high, this.widest?.[1] ?? high)];
    return this.widest;
  }

  private take(chart: uPlot): void {
    const { left, width } = chart.select;
    if (width < 4) return;
    const across = scale(this.plan.across ?? "time").factor;
    const [from, to] = [left, left + width].map((at) => chart.posToVal(at, "x") / across);
    chart.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    this.plan.dragged?.(from ?? 0, to ?? 0);
  }

  private shade(chart: uPlot): void {
    const { ctx, bbox } = chart;
    for (const span of this.spans) {
      const ends = [span.from_s, span.to_s].map((at) =>
        Math.min(Math.max(chart.valToPos(at, "x", true), bbox.left), bbox.left + bbox.width),
      );
      const [left = 0, right = 0] = ends;
      ctx.fillStyle = token(`--${span.shade}`);
      ctx.fillRect(left, bbox.top, right - left, bbox.height);
    }
  }
}

/** One rem, pixels: charts grow with the text. */
function rootSize(): number {
  return parseFloat(getComputedStyle(document.documentElement).fontSize);
}

function label(value: number): string {
  if (value === 0) return "0";
  const size = Math.abs(value);
  return (size < 1e-3 || size >= 1e5 ? value.toExponential(0) : `${+value.toPrecision(4)}`).replace("-", "−");
}

function spread(low: number | null, high: number | null, least: number): [number, number] {
  if (low === null || high === null) {
    const half = 1.2 * Math.max(least / 2, 1);
    return [-half, half];
  }
  const room = Math.max(0.06 * (high - low), 0.5 * (least - (high - low)), 1e-6);
  return [low - room, high + room];
}
