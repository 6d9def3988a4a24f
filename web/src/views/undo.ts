//! What a trial or a commission has changed on an autopilot, put back: looked at, agreed to, written.

import { previewUndo, undoCommission, type UndoPreview } from "../api/client.ts";
import type { Live } from "../api/live.ts";
import { element, fill, say } from "../element.ts";
import { Complaints } from "../notice.ts";
import { significant } from "../units.ts";
import { sentence } from "../words.ts";
import { table } from "./inspected.ts";

const WRITTEN = "The autopilot has these values; each was written and read back.";

/** `vehicle` is the name of the autopilot that is chosen. */
export function undoPanel(
  live: Live,
  vehicle: () => string,
): {
  readonly root: HTMLElement;
  draw(): void;
  /** Looks at the old values, and brings them in sight. */
  readonly look: () => void;
} {
  const complaints = new Complaints();
  const place = element("div", { class: "stack", "aria-live": "polite" });
  const why = element("p", { class: "hint", role: "status" });
  const agreed = element("input", { type: "checkbox", onchange: () => draw() });
  const look = element("button", { type: "button", onclick: () => void preview() }, "Look at the old values");
  const write = element(
    "button",
    { class: "main", type: "button", disabled: true, onclick: () => void putBack() },
    "Put the old values back",
  );
  let found: UndoPreview | null = null;
  let busy = false;
  const during = async (work: () => Promise<void>): Promise<void> => {
    busy = true;
    draw();
    await work();
    busy = false;
    draw();
  };
  const preview = (): Promise<void> =>
    during(async () => {
      agreed.checked = false;
      fill(place, element("p", {}, "Looking at the autopilot. This takes up to 20\u00a0s."));
      found = await complaints.hear(() => previewUndo({ vehicle: vehicle() }));
      fill(place, ...(found === null ? [] : shownValues(found)));
    });
  const putBack = (): Promise<void> =>
    during(async () => {
      const order = { vehicle: vehicle(), undo: found?.undo ?? null, agreed: agreed.checked };
      const done = await complaints.hear(() => undoCommission(order));
      found = null;
      agreed.checked = false;
      if (done === null) return fill(place);
      const tone = done.complete ? "good" : "bad";
      const loud = done.complete ? "✓ The old values are back" : "✗ Not everything is back";
      fill(
        place,
        element(
          "div",
          { class: `notice ${tone}` },
          element("p", { class: "loud" }, loud),
          element("p", {}, done.complete ? WRITTEN : sentence(done.line)),
        ),
        values("Put back", ["parameter", "was", "is now"], done.parameters),
      );
    });
  const obstacle = (): string => {
    if (live.trial?.running === true || live.commission?.running === true) return "A trial or a commission is running.";
    if (found === null) return "Look at the old values first.";
    if (live.control?.is_you !== true) return "Take control first, under Control.";
    return agreed.checked ? "" : "Agree that the parameters are written.";
  };
  const draw = (): void => {
    look.disabled = busy || vehicle() === "";
    write.disabled = busy || obstacle() !== "";
    if (!busy) say(why, obstacle());
  };
  const root = element(
    "section",
    { class: "panel stack undo", "aria-label": "Put the old values back" },
    element("h2", {}, "Undo"),
    element("p", {}, "What the last commission, or a trial that was cut short, has changed on the autopilot."),
    element("div", { class: "row" }, look),
    complaints.root,
    place,
    element("label", { class: "choice" }, agreed, "These parameters may be written"),
    why,
    element("div", { class: "row" }, write),
  );
  const lookHere = (): void => {
    root.scrollIntoView();
    void preview();
  };
  return { root, draw, look: lookHere };
}

type Value = UndoPreview["parameters"][number];

function values(name: string, heads: readonly string[], rows: readonly Value[]): HTMLElement {
  const number = (value: number | null | undefined): string => (value == null ? "not answered" : significant(value));
  return table(
    name,
    heads,
    rows.map((one) => [one.name, number(one.from), number(one.to)]),
  );
}

function shownValues(found: UndoPreview): HTMLElement[] {
  const mode = found.has_mode ? " The mode is put back, too, unless somebody has chosen another since." : "";
  return [
    values("Now and before", ["parameter", "now", "old"], found.parameters),
    element("p", { class: "hint" }, `The old values are kept in ${found.file}.${mode}`),
  ];
}
