//! A figure of the docs that is computed where it is read: sliders, a drawing, and a sentence with its numbers.

import "./figure.css";
import { element, say } from "../../element.ts";
import type { Program } from "../module.ts";
import { asFile, draw, type Drawn, emptyDrawing } from "./drawing.ts";
import { intervals } from "./intervals.ts";
import { lag } from "./lag.ts";
import { type Found, type Trial, Trials } from "./trials.ts";

interface Slider {
  readonly name: string;
  readonly label: string;
  readonly min: number;
  readonly max: number;
  readonly step: number;
  readonly value: number;
}

type Several = readonly (Found | null)[];

export interface FigureOf {
  readonly name: string;
  readonly sliders: readonly Slider[];
  trials(values: readonly number[]): Trial[];
  drawn(found: Several, values: readonly number[]): Drawn;
  said(found: Several, values: readonly number[]): string;
}

export const FIGURES: Readonly<Record<string, FigureOf>> = { intervals, lag };

/** What a page around the figure gets: that it is there, and how high it is. */
interface Announcement {
  readonly seatrial: "figure";
  readonly height: number;
}

export function openFigure(program: Program, figure: FigureOf): { readonly root: HTMLElement; drop(): void } {
  const trials = new Trials(program);
  const drawing = emptyDrawing();
  const sentence = element("p", { class: "figure-said", "aria-live": "polite" });
  const inputs = figure.sliders.map(({ name, label, ...rest }) => {
    const shown = element("output", {}, String(rest.value));
    const input = element("input", { type: "range", name, ...rest });
    input.addEventListener("input", () => {
      shown.textContent = input.value;
      play();
    });
    return { input, field: element("label", { class: "field" }, element("span", {}, `${label}: `, shown), input) };
  });
  const root = element(
    "section",
    { class: "figure stack", "aria-label": figure.name },
    drawing,
    sentence,
    element("div", { class: "fields" }, ...inputs.map(({ field }) => field)),
  );
  /** The trials that were asked for last, and what was found in them. */
  let asked = "";
  let latest: Several = [];
  const show = (found: Several, isWhole: boolean): void => {
    const values = inputs.map(({ input }) => Number(input.value));
    draw(drawing, figure.drawn(found, values));
    if (!isWhole) return;
    say(sentence, figure.said(found, values));
    root.dataset["whole"] = asked;
    tell(root);
  };
  const play = (): void => {
    const wanted = figure.trials(inputs.map(({ input }) => Number(input.value)));
    const key = JSON.stringify(wanted);
    if (key === asked) {
      show(latest, latest.length === wanted.length);
      return;
    }
    asked = key;
    trials.play(wanted, (found) => {
      latest = [...found];
      show(latest, latest.length === wanted.length);
    });
  };
  const watcher = new ResizeObserver(() => root.dataset["whole"] !== undefined && tell(root));
  watcher.observe(root);
  Object.assign(window, { figureAsFile: () => asFile(drawing) });
  play();
  return { root, drop: () => watcher.disconnect() };
}

function tell(root: HTMLElement): void {
  const announcement: Announcement = { seatrial: "figure", height: Math.ceil(root.getBoundingClientRect().height) };
  if (parent !== window) parent.postMessage(announcement, "*");
}
