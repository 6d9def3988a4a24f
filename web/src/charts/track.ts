//! The track from above with the area that may not be left, north up, the same scale both ways.

import { element, fill, say, svg } from "../element.ts";
import { onUnits, shown } from "../units.ts";

/** North and east, m. */
export type Place = readonly [number, number];

export interface Seen {
  readonly track: readonly Place[];
  /** Null where no area is spoken of. */
  readonly area: readonly Place[] | null;
  /** Least and greatest north, least and greatest east. */
  readonly box?: readonly number[] | null;
  readonly heading_rad: number | null;
}

const WIDTH = 420;
const HEIGHT = 300;
const MARGIN = 22;

export class Track {
  readonly figure: HTMLElement;
  private readonly drawing = svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", class: "track" });
  private readonly note = element("span", { class: "legend" });
  private seen: Seen = { track: [], area: [], heading_rad: null };
  readonly drop: () => void;

  constructor(title: string) {
    this.figure = element(
      "figure",
      { class: "chart" },
      element("figcaption", {}, element("span", { class: "title" }, title), this.note),
      this.drawing,
    );
    this.drop = onUnits(() => this.set(this.seen));
    this.set(this.seen);
  }

  set(seen: Seen): void {
    this.seen = seen;
    const { track } = seen;
    const area = seen.area ?? [];
    const [south, north, west, east] = seen.box ?? [];
    const box: Place[] =
      south === undefined || north === undefined || west === undefined || east === undefined
        ? []
        : [
            [south, west],
            [north, east],
          ];
    const all = [...track, ...area, ...box];
    if (all.length === 0) {
      this.drawing.setAttribute("aria-label", "No position yet.");
      fill(this.drawing, svg("text", { x: WIDTH / 2, y: HEIGHT / 2, class: "middle" }, "no position yet"));
      say(this.note, "");
      return;
    }
    const [low, high] = ends(all);
    const size = Math.max(high[0] - low[0], (high[1] - low[1]) * ((HEIGHT - 2 * MARGIN) / (WIDTH - 2 * MARGIN)), 5);
    const perMetre = (HEIGHT - 2 * MARGIN) / size;
    const middle: Place = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2];
    const x = ([, e]: Place): number => WIDTH / 2 + (e - middle[1]) * perMetre;
    const y = ([n]: Place): number => HEIGHT / 2 - (n - middle[0]) * perMetre;
    const path = (places: readonly Place[]): string =>
      places.map((p, i) => `${i === 0 ? "M" : "L"}${x(p).toFixed(1)} ${y(p).toFixed(1)}`).join("");
    const step = scaleBar(size);
    const last = track.at(-1);
    fill(
      this.drawing,
      area.length > 2 ? svg("path", { class: "area", d: `${path(area)}Z` }) : null,
      box.length === 2 && box[0] !== undefined && box[1] !== undefined
        ? svg("rect", {
            class: "expected",
            x: x(box[0]),
            y: y(box[1]),
            width: x(box[1]) - x(box[0]),
            height: y(box[0]) - y(box[1]),
          })
        : null,
      svg("path", { class: "path", d: path(track) }),
      last === undefined
        ? null
        : svg("path", {
            class: "vessel",
            d: "M0-11L6 8L0 4L-6 8Z",
            transform: `translate(${x(last)} ${y(last)}) rotate(${((seen.heading_rad ?? 0) * 180) / Math.PI})`,
          }),
      svg("path", { class: "scale", d: `M${MARGIN} ${HEIGHT - 8}v-4v4h${step * perMetre}v-4` }),
      svg("text", { x: MARGIN, y: HEIGHT - 16 }, shown(step, "distance", 2)),
      svg("path", { class: "scale", d: `M${WIDTH - 16} 30V10m-4 6l4-6l4 6` }),
      svg("text", { x: WIDTH - 16, y: 44, class: "middle" }, "N"),
    );
    const wide = shown(high[1] - low[1], "distance", 2);
    const tall = shown(high[0] - low[0], "distance", 2);
    const said = area.length > 2 ? "the dashed line may not be left" : "no area is set";
    say(this.note, seen.area === null ? "" : said);
    this.drawing.setAttribute("aria-label", `Track seen from above: ${wide} west to east, ${tall} south to north.`);
  }
}

function ends(places: readonly Place[]): [Place, Place] {
  let [low, high]: [Place, Place] = [
    [Infinity, Infinity],
    [-Infinity, -Infinity],
  ];
  for (const [n, e] of places) {
    low = [Math.min(low[0], n), Math.min(low[1], e)];
    high = [Math.max(high[0], n), Math.max(high[1], e)];
  }
  return [low, high];
}

/** 1, 2 or 5 times a power of ten, about a quarter of the size. */
function scaleBar(size: number): number {
  const wanted = size / 4;
  const power = 10 ** Math.floor(Math.log10(wanted));
  const [step = 1] = [5, 2, 1].filter((factor) => factor * power <= wanted);
  return step * power;
}
