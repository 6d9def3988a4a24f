//! How a log is to be read, and which parts of it are for training and for validation.

import type { LogColumns } from "../api/client.ts";
import { element, fill } from "../element.ts";

/** Columns, topics or fields of messages that a log may need to be told. */
const COLUMNS: readonly (readonly [name: string, label: string])[] = [
  ["time", "Time"],
  ["heading", "Heading"],
  ["rudder", "Rudder"],
  ["speed", "Forward speed"],
  ["yaw_rate", "Yaw rate"],
  ["thrust", "Thrust"],
  ["depth", "Depth"],
  ["roll", "Roll"],
  ["pitch", "Pitch"],
  ["north", "North"],
  ["east", "East"],
];

/** So many of them are always shown. */
const FIRST = 6;

/** Columns that a log must have. */
const NEEDED = ["time", "heading", "rudder"];

export interface ReadingForm {
  readonly root: HTMLDetailsElement;
  reading(): Record<string, string>;
  /** Lets the log be read again, by these columns in these units; null where its columns are not known. */
  allow(columns: LogColumns | null): void;
}

/** Where the names of a log do not say what it holds. */
export function readingForm(again: () => void): ReadingForm {
  const field = (label: string, input: HTMLElement): HTMLElement => element("label", { class: "field" }, label, input);
  const number = (name: string, label: string, most?: number): HTMLElement =>
    field(label, element("input", { name, type: "number", min: 0, max: most, step: "any" }));
  const columns = COLUMNS.map(([name, label]) => [label, element("select", { name })] as const);
  const units = COLUMNS.map(([quantity, label]) => {
    const select = element("select", {}, element("option", { value: "" }, "as its name or values say"));
    return { quantity, label, select };
  });
  /** Every unit that the program knows for a quantity. */
  const measure = (known: LogColumns["units"]): void => {
    for (const { quantity, select } of units)
      if (select.options.length === 1)
        select.append(...(known[quantity] ?? []).map((name) => element("option", { value: name }, name)));
  };
  const offer = (names: readonly string[]): void => {
    for (const [, select] of columns) {
      const chosen = select.value;
      fill(
        select,
        element("option", { value: "" }, "found by its name"),
        NEEDED.includes(select.name)
          ? null
          : element("option", { value: "none", selected: chosen === "none" }, "left out"),
        ...names.map((name) => element("option", { value: name, selected: name === chosen }, name)),
      );
    }
  };
  offer([]);
  const invalid = element("input", { type: "checkbox", name: "drop_invalid", value: "true" });
  const button = element("button", { type: "submit", disabled: true }, "Look at the log again");
  const form = element(
    "form",
    {
      class: "stack",
      onsubmit: (event: Event) => {
        event.preventDefault();
        again();
      },
    },
    element(
      "div",
      { class: "fields" },
      ...columns.slice(0, FIRST).map(([label, select]) => field(`${label} from column`, select)),
      ...units.slice(0, FIRST).map(({ label, select }) => field(`${label} is in`, select)),
      number("rudder_range_deg", "Rudder angle at full deflection, °", 90),
      number("rudder_trim_us", "Pulse width of the neutral rudder, µs"),
      number("rudder_delay_s", "Dead time of the servo, s"),
      number("rudder_lag_s", "Time constant of the servo, s"),
    ),
    element(
      "details",
      {},
      element("summary", {}, "Depth, roll, pitch, position"),
      element(
        "div",
        { class: "fields" },
        ...columns.slice(FIRST).map(([label, select]) => field(`${label} from column`, select)),
        ...units.slice(FIRST).map(({ label, select }) => field(`${label} is in`, select)),
      ),
    ),
    element("label", { class: "choice" }, invalid, "Leave out damaged rows"),
    element("div", { class: "row" }, button),
  );
  return {
    root: element("details", { class: "panel" }, element("summary", {}, "Columns and units"), form),
    reading: () => {
      const given = [...new FormData(form)].map(([name, value]) => [name, String(value).trim()] as const);
      const named = given.filter(([, value]) => value !== "");
      const chosen = units.filter(({ select }) => select.value !== "");
      const units_ = chosen.map(({ quantity, select }) => `${quantity}=${select.value}`).join(",");
      return { ...Object.fromEntries(named), ...(units_ === "" ? {} : { units: units_ }) };
    },
    allow: (columns) => {
      button.disabled = false;
      offer(columns?.columns ?? []);
      if (columns !== null) measure(columns.units);
    },
  };
}

interface Stretch {
  readonly from_s: number;
  readonly to_s: number;
}

export interface WindowsForm {
  readonly root: HTMLElement;
  reading(): Record<string, string>;
  /** Shows the windows that were used. */
  propose(training: Stretch | null, validation: Stretch | null): void;
  /** Takes a segment of the record that was dragged over. */
  readonly drag: (from_s: number, to_s: number) => void;
  /** Forgets what was chosen. */
  clear(): void;
}

const WINDOWS = [
  ["from_s", "Training from, s"],
  ["to_s", "to, s"],
  ["validate_from_s", "Validation from, s"],
  ["validate_to_s", "to, s"],
] as const;

/** Windows by hand, dragged over the record or typed. Until then the manoeuvres are found. */
export function windowsForm(again: () => void): WindowsForm {
  const inputs = WINDOWS.map(([name]) => element("input", { name, type: "number", step: "any" }));
  let isChosen = false;
  inputs.forEach((input) => input.addEventListener("input", () => (isChosen = true)));
  const pick = (value: string, label: string): HTMLElement =>
    element(
      "label",
      { class: "choice" },
      element("input", { type: "radio", name: "window", value, checked: value === "train" }),
      label,
    );
  const picks = element("div", { class: "row" }, pick("train", "training"), pick("validate", "validation"));
  const put = (at: number, value: number | undefined): void => {
    const input = inputs[at];
    if (input !== undefined) input.value = value === undefined ? "" : `${+value.toFixed(2)}`;
  };
  const clear = (): void => {
    isChosen = false;
    inputs.forEach((_, at) => put(at, undefined));
  };
  const root = element(
    "form",
    {
      class: "stack",
      "aria-label": "Windows",
      onsubmit: (event: Event) => {
        event.preventDefault();
        isChosen = true;
        again();
      },
    },
    element("h3", {}, "Windows"),
    element("p", { class: "hint" }, "Drag across the record, or type. A drag marks the window for"),
    picks,
    element(
      "div",
      { class: "fields" },
      ...WINDOWS.map(([, label], at) => element("label", { class: "field" }, label, inputs[at])),
    ),
    element(
      "div",
      { class: "row" },
      element("button", { class: "main", type: "submit" }, "Identify with these windows"),
      element("button", { type: "button", onclick: () => (clear(), again()) }, "Find the manoeuvres"),
    ),
  );
  return {
    root,
    reading: () => {
      const given = inputs.map((input, at) => [WINDOWS[at]?.[0] ?? "", input.value] as const);
      return isChosen ? Object.fromEntries(given.filter(([, value]) => value !== "")) : {};
    },
    propose: (training, validation) => {
      if (isChosen) return;
      [training?.from_s, training?.to_s, validation?.from_s, validation?.to_s].forEach((value, at) => put(at, value));
    },
    drag: (from_s, to_s) => {
      const chosen = picks.querySelector<HTMLInputElement>("input:checked")?.value;
      const first = chosen === "validate" ? 2 : 0;
      isChosen = true;
      put(first, from_s);
      put(first + 1, to_s);
    },
    clear,
  };
}
