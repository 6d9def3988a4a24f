//! What a person can do here, and what comes after a trial.

import { download, type TrialState } from "../api/client.ts";
import type { Live } from "../api/live.ts";
import { element, fill } from "../element.ts";
import { Complaints } from "../notice.ts";
import { isUsable } from "../words.ts";
import { resume } from "./runs.ts";

const WAYS: readonly (readonly [to: string, name: string, what: string])[] = [
  ["#/control/rehearse", "Rehearse", "A whole trial on a simulated vehicle. Nothing moves."],
  ["#/control/trial", "Trial", "On your own vehicle: it is checked first, then it moves."],
  ["#/history/log", "Open a log", "Find out from a log how a vehicle steers."],
];

/** Three buttons for who comes here first. */
export function startPanel(): HTMLElement {
  return element(
    "section",
    { class: "panel stack", "aria-label": "What can I do here?" },
    element("h2", {}, "What can I do here?"),
    element(
      "div",
      { class: "starts" },
      ...WAYS.map(([to, name, what]) =>
        element("a", { class: "start", href: to }, element("b", {}, name), element("span", {}, what)),
      ),
    ),
  );
}

/** The next steps after a trial: its models, its report, and what is left of its plan. */
export function afterTrial(live: Live): { root: HTMLElement; draw(): void } {
  const complaints = new Complaints();
  const root = element("section", { class: "panel stack", "aria-label": "What comes next" });
  let shown = "";
  return {
    root,
    draw: () => {
      const trial = live.trial;
      const isOver = trial !== null && !trial.running;
      root.hidden = !isOver;
      const key = isOver ? `${trial.campaign} ${trial.outcome?.finished}` : "";
      if (key === shown) return;
      shown = key;
      if (isOver) fill(root, ...steps(trial, complaints));
    },
  };
}

function steps(trial: TrialState, complaints: Complaints): (HTMLElement | null)[] {
  const { campaign } = trial;
  const report = (): void =>
    void complaints.hear(() => download(`campaigns/${campaign}/report.html`, `campaign-${campaign}.html`));
  const hasModel = trial.runs.some(isUsable);
  const proven = hasModel ? commission(trial.vehicle, campaign) : null;
  return [
    element("h2", {}, "What comes next"),
    complaints.root,
    trial.outcome?.finished === true ? null : resume(trial, complaints),
    proven,
    element(
      "div",
      { class: "row" },
      element(
        "a",
        { class: proven === null ? "file main" : "file", href: `#/history/campaign/${campaign}` },
        hasModel ? "Gains, limits and files" : "Why, runs and files",
      ),
      element("button", { class: "file", type: "button", onclick: report }, "Report"),
      element("a", { class: "file", href: "#/control" }, "Another trial"),
      element("a", { class: "file", href: "#/history" }, "Compare with another"),
      element("a", { class: "file", href: "#/history/log" }, "Open a log"),
    ),
  ];
}

/** How the gains of a campaign get into the autopilot that it was made on. */
export function commission(vehicle: string, campaign: number): HTMLElement | null {
  if (!vehicle.startsWith("mavlink:")) return null;
  return element(
    "div",
    {},
    element("p", {}, "The gains into the autopilot: tried with heading steps, kept or put back."),
    element(
      "div",
      { class: "row" },
      element("a", { class: "file main", href: `#/commission/${campaign}` }, "Commission the gains"),
    ),
  );
}
