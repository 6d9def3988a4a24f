//! How much of a limit is used.

import { element, say } from "../element.ts";

const NEAR = 0.7;

export class Gauge {
  readonly row: HTMLElement;
  private readonly bar = element("span", { class: "bar-filled" });
  private readonly meter: HTMLElement;
  private readonly value = element("output", {});

  constructor(name: string) {
    this.meter = element(
      "div",
      { class: "meter", role: "meter", "aria-label": name, "aria-valuemin": 0, "aria-valuemax": 100 },
      this.bar,
    );
    this.row = element("div", { class: "gauge" }, element("span", {}, name), this.meter, this.value);
  }

  /** `used` is 1 at the limit. */
  set(used: number): void {
    const percent = Math.round(100 * Math.min(Math.max(used, 0), 1));
    this.row.classList.toggle("near", used >= NEAR);
    this.bar.style.width = `${percent}%`;
    this.meter.setAttribute("aria-valuenow", String(percent));
    say(this.value, `${Math.round(100 * used)} %${used >= NEAR ? " ▲" : ""}`);
  }
}
