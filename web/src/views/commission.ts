//! Gains into an autopilot: those that it has beside those proposed, heading steps as they are made, and what came of it.

import {
  type CampaignSummary,
  campaigns,
  commissionSince,
  type CommissionOrder,
  type CommissionPreview,
  type CommissionState,
  type ExpectedSteps,
  type MeasuredSteps,
  previewCommission,
  startCommission,
  vehicles,
} from "../api/client.ts";
import type { Live } from "../api/live.ts";
import { Strip } from "../charts/strip.ts";
import { element, fill, say } from "../element.ts";
import { Complaints } from "../notice.ts";
import type { View } from "../shell.ts";
import { clock, onUnits, shown, significant } from "../units.ts";
import { sentence, type Tone } from "../words.ts";
import { checklist } from "./checks.ts";
import { undoPanel } from "./undo.ts";

const ASK_EVERY_MS = 250;
const MOST_POINTS = 6000;
const NO_CONTROL = "Take control first.";
/** The form, whose last button stands behind the proposal. */
const FORM = "commission-order";

const ENDS: Record<NonNullable<CommissionState["ended"]>, readonly [tone: Tone, words: string]> = {
  kept: ["good", "✓ The new gains stay"],
  put_back: ["partly", "! The old gains are back"],
  refused: ["partly", "! Nothing was written"],
  aborted: ["bad", "✗ Stopped: the old gains are back"],
};

/** `#/commission`, `#/commission/3` with the models of campaign 3. */
export function openCommission(live: Live): View {
  const complaints = new Complaints();
  const form = orderForm(live, complaints);
  const undo = undoPanel(live, form.vehicle);
  const shownNow = steps(undo.look);
  let seen = "";
  const ordering = element(
    "div",
    { class: "panels commission spaced" },
    form.root,
    form.proposal,
    form.begin,
    undo.root,
  );
  const draw = (): void => {
    form.draw();
    undo.draw();
    const { commission } = live;
    ordering.hidden = commission?.running === true;
    // Another commission, or another end of it, as by an undo: the samples are asked for again.
    const key = JSON.stringify([commission?.started, commission?.running, commission?.ended]);
    if (key === seen) return;
    seen = key;
    if (commission !== null) shownNow.follow(commission);
  };
  const unwatch = live.watch(draw);
  draw();
  return {
    root: element("div", {}, complaints.root, shownNow.root, ordering),
    drop: () => {
      unwatch();
      form.drop();
      shownNow.drop();
    },
  };
}

interface OrderForm {
  readonly root: HTMLElement;
  /** The autopilot that is chosen; empty where there is none. */
  vehicle(): string;
  readonly proposal: HTMLElement;
  /** What is agreed to and started once the proposal is read. */
  readonly begin: HTMLElement;
  draw(): void;
  drop(): void;
}

function orderForm(live: Live, complaints: Complaints): OrderForm {
  const vehicle = element("select", { required: true });
  const campaign = element("select", { required: true });
  const step = element("input", { type: "number", min: 5, max: 90, value: 30, required: true });
  const speed = element("input", { type: "number", min: 0, step: "any", placeholder: "the autopilot's own" });
  const rehearsal = element("input", { type: "checkbox" });
  const agreed = element("input", { type: "checkbox" });
  const why = element("p", { class: "hint", role: "status" });
  const control = element("a", { class: "file", href: "#/control" }, "Take control");
  const none = element(
    "p",
    { class: "notice partly", hidden: true },
    "This server has no autopilot. Start it with one: seatrial serve --vehicle mavlink:udp:0.0.0.0:14550",
  );
  const noCampaign = element(
    "p",
    { class: "notice partly", hidden: true },
    "No trial on a boat has given a usable model yet. Run one first, or use models of a rehearsal.",
  );
  const look = element("button", { type: "button", onclick: () => void preview() }, "Look at the autopilot");
  const start = element(
    "button",
    { class: "main", type: "submit", form: FORM, disabled: true },
    "Start the heading steps",
  );
  const proposal = element("section", { class: "panel stack proposal", "aria-label": "Gains now and proposed" });
  /** Until they are read none are known. */
  let known: CampaignSummary[] | null = null;
  let found: CommissionPreview | null = null;
  let busy = false;

  const order = (): CommissionOrder => ({
    vehicle: vehicle.value,
    campaign: Number(campaign.value),
    at_speed_m_s: Number.isFinite(speed.valueAsNumber) ? speed.valueAsNumber : null,
    step_rad: (step.valueAsNumber * Math.PI) / 180,
    rehearsal: rehearsal.checked,
  });
  const forget = (): void => {
    found = null;
    agreed.checked = false;
    fill(
      proposal,
      element("h2", {}, "Gains now and proposed"),
      element("p", {}, "Look at the autopilot first. It is not touched."),
    );
    draw();
  };
  const preview = async (): Promise<void> => {
    if (!root.reportValidity()) return;
    busy = true;
    fill(
      proposal,
      element("h2", {}, "Gains now and proposed"),
      element("p", {}, "Looking at the autopilot. This takes up to 20\u00a0s."),
    );
    draw();
    const answer = await complaints.hear(() => previewCommission(order()));
    busy = false;
    if (answer === null) forget();
    else {
      found = answer;
      drawProposal(proposal, answer);
    }
    draw();
  };
  const begin = async (event: Event): Promise<void> => {
    event.preventDefault();
    busy = true;
    say(why, "The vehicle is being taken …");
    draw();
    const started = await complaints.hear(() =>
      startCommission({ ...order(), proposal: found?.proposed?.proposal ?? null, agreed: agreed.checked }),
    );
    busy = false;
    if (started !== null) {
      forget();
      scrollTo(0, 0);
    }
    draw();
  };
  for (const field of [vehicle, campaign, step, speed, rehearsal]) field.addEventListener("change", forget);
  agreed.addEventListener("change", () => draw());
  const root = element(
    "form",
    { id: FORM, class: "panel stack order", onsubmit: (event: Event) => void begin(event) },
    element("h2", {}, "Gains into the autopilot"),
    element(
      "p",
      {},
      "The boat makes heading steps with its present gains, then with the new ones. New gains stay only where they do no worse. Whatever else happens, the old ones are put back.",
    ),
    none,
    noCampaign,
    element("label", { class: "field" }, "Autopilot", vehicle),
    element("label", { class: "field" }, "Models of the trial", campaign),
    element(
      "div",
      { class: "fields" },
      element("label", { class: "field" }, "Size of a step, °", step),
      element("label", { class: "field" }, "Speed of the model, m/s", speed),
    ),
    element("label", { class: "choice" }, rehearsal, "Use models of a rehearsal as well"),
    element("div", { class: "row" }, look),
  );
  const beginning = element(
    "section",
    { class: "panel stack begin", "aria-label": "Start" },
    element("label", { class: "choice" }, agreed, "The boat may move, and its gains may be changed"),
    why,
    element("div", { class: "row" }, start, control),
  );
  const obstacle = (): string => {
    if (live.trial?.running === true) return "A trial is running.";
    if (live.commission?.running === true) return "A commission is running.";
    if (live.control?.is_you !== true) return NO_CONTROL;
    if (found === null) return "Look at the autopilot first.";
    if (!found.ready) return "The autopilot is not ready: see what is marked.";
    return agreed.checked ? "" : "Agree that the boat moves.";
  };
  const draw = (): void => {
    look.disabled = busy || known === null || live.commission?.running === true;
    if (!busy) say(why, obstacle());
    control.hidden = obstacle() !== NO_CONTROL;
    start.disabled = busy || obstacle() !== "";
  };
  /** The campaigns whose models may be chosen. */
  const offer = (): void => {
    if (known === null) return;
    const offered = known.filter((one) => rehearsal.checked || one.seed == null);
    noCampaign.hidden = offered.length > 0;
    fill(
      campaign,
      ...offered.map((one) =>
        element(
          "option",
          { value: one.id },
          `No. ${one.id}, ${one.configuration}, ${one.started.slice(0, 10)}, ${one.vehicle}`,
        ),
      ),
    );
  };
  rehearsal.addEventListener("change", offer);
  const list = async (): Promise<void> => {
    const answer = await complaints.hear(vehicles);
    const all = await complaints.hear(campaigns);
    if (answer === null || all === null) return;
    const autopilots = answer.vehicles.filter((one) => one.has_gains);
    none.hidden = autopilots.length > 0;
    fill(vehicle, ...autopilots.map((one) => element("option", { value: one.name }, one.name)));
    known = all.filter((one) => one.runs_accepted > 0 && one.verdict !== "do_not_use").reverse();
    const wish = known.find((one) => one.id === Number(location.hash.split("/")[2]));
    if (wish?.seed != null) rehearsal.checked = true;
    offer();
    const wished = wish ?? known.find((one) => one.vehicle === vehicle.value);
    if (wished !== undefined) {
      campaign.value = String(wished.id);
      if (autopilots.some((one) => one.name === wished.vehicle)) vehicle.value = wished.vehicle;
    }
    draw();
  };
  forget();
  void list();
  const forgetUnits = onUnits(() => found !== null && drawProposal(proposal, found));
  return { root, vehicle: () => vehicle.value, proposal, begin: beginning, draw, drop: forgetUnits };
}

function drawProposal(place: HTMLElement, found: CommissionPreview): void {
  const { proposed } = found;
  const failed = found.checks.filter((check) => !check.passed);
  fill(
    place,
    element("h2", {}, "Gains now and proposed"),
    element(
      "p",
      {},
      element("span", { class: `badge ${found.ready ? "good" : "bad"}` }, found.ready ? "✓ ready" : "✗ not ready"),
    ),
    failed.length === 0 ? null : checklist(failed),
    found.refused ? element("p", { class: "notice bad" }, sentence(found.refused)) : null,
    proposed ? gainsTable(proposed.parameters, "now", null) : null,
    proposed ? expectations(proposed.old_expected, proposed.new_expected) : null,
    proposed
      ? element(
          "p",
          {},
          `The steps take at most ${clock(proposed.duration_s)} min${proposed.surge_speed_m_s ? ` at ${shown(proposed.surge_speed_m_s, "speed")}` : ""}${proposed.distance_m ? `: ${shown(proposed.distance_m, "distance")} of free water ahead` : ""}.`,
        )
      : null,
    found.changes.length === 0
      ? null
      : element(
          "details",
          {},
          element("summary", {}, "Changed until the boat is handed back"),
          element(
            "ul",
            {},
            ...found.changes.map((change) =>
              element(
                "li",
                {},
                `${change.name}: ${significant(change.from)} → ${significant(change.to)}, ${change.why}`,
              ),
            ),
          ),
        ),
    failed.length > 0
      ? null
      : element("details", {}, element("summary", {}, `${found.checks.length} checks passed`), checklist(found.checks)),
  );
}

type Gains = "before" | "new";

/**
 * Each parameter with its reason below it. `old` is what the gains before are called; `inUse` are those that the autopilot
 * has, where that is to be said.
 */
function gainsTable(
  parameters: CommissionState["proposed"]["parameters"],
  old: "now" | "before",
  inUse: Gains | null,
): HTMLElement {
  const columns: readonly Gains[] = ["before", "new"];
  const strong = (gains: Gains): string => ((inUse ?? "new") === gains ? "strong" : "");
  const heads = columns.map((gains) =>
    element(
      "th",
      { scope: "col" },
      gains === "before" ? old : gains,
      inUse === gains && element("span", { class: "interval" }, "in use now"),
    ),
  );
  const rows = parameters.flatMap((one) => [
    element(
      "tr",
      { class: "explained" },
      element("th", { scope: "row", class: "words" }, one.name),
      element("td", { class: strong("before") }, significant(one.from)),
      element("td", { class: strong("new") }, significant(one.to)),
    ),
    element("tr", {}, element("td", { class: "words hint", colspan: 3 }, one.why)),
  ]);
  return element(
    "div",
    {
      class: "table-box",
      tabindex: 0,
      role: "region",
      "aria-label": old === "now" ? "Parameters proposed" : "Parameters before and new",
    },
    element(
      "table",
      {},
      element("thead", {}, element("tr", {}, element("th", { scope: "col", class: "words" }, "parameter"), ...heads)),
      element("tbody", {}, ...rows),
    ),
  );
}

const range = ([low = NaN, high = NaN]: readonly number[], digits = 2): string =>
  `${significant(low, digits)} to ${significant(high, digits)}`;

const percents = (bounds: readonly number[]): string =>
  `${bounds.map((bound) => Math.round(100 * bound)).join(" to ")}\u00a0%`;

function expectations(before: ExpectedSteps, after: ExpectedSteps): HTMLElement {
  const row = (name: string, cells: readonly [string, string]): HTMLElement =>
    element(
      "tr",
      {},
      element("th", { scope: "row", class: "words" }, name),
      ...cells.map((cell) => element("td", {}, cell)),
    );
  return compared(
    "What the model expects",
    ["present gains", "new gains"],
    [
      row("overshoot", [percents(before.overshoot), percents(after.overshoot)]),
      row("settles in, s", [range(before.settling_s), range(after.settling_s)]),
      row("rudder, % of full a second", [percents(before.rudder_per_s), percents(after.rudder_per_s)]),
    ],
  );
}

function measurements(before: MeasuredSteps | null, after: MeasuredSteps | null): HTMLElement | null {
  if (before === null) return null;
  const row = (name: string, of: (one: MeasuredSteps) => string): HTMLElement =>
    element(
      "tr",
      {},
      element("th", { scope: "row", class: "words" }, name),
      ...[before, after].map((one) => element("td", {}, one === null ? "–" : of(one))),
    );
  return compared(
    "What the steps were",
    ["old gains", "new gains"],
    [
      row("overshoot", (one) => `${Math.round(100 * one.overshoot)}\u00a0%`),
      row("settles in, s", (one) => (one.settling_s == null ? "not" : significant(one.settling_s, 2))),
      row("error at the end", (one) => shown(one.steady_error_rad, "angle", 2)),
      row("rudder, % of full a second", (one) => `${Math.round(100 * one.rudder_per_s)}\u00a0%`),
    ],
  );
}

function compared(title: string, heads: readonly string[], rows: readonly HTMLElement[]): HTMLElement {
  return element(
    "div",
    { class: "table-box", tabindex: 0, role: "region", "aria-label": title },
    element(
      "table",
      {},
      element("caption", {}, title),
      element(
        "thead",
        {},
        element("tr", {}, element("td", {}), ...heads.map((head) => element("th", { scope: "col" }, head))),
      ),
      element("tbody", {}, ...rows),
    ),
  );
}

/** The gains that the autopilot has: while steps are made, and where something is left to be put back, it may be either. */
function inUse({ ended, needs_restoring }: CommissionState): Gains | null {
  if (ended == null || needs_restoring) return null;
  return ended === "kept" ? "new" : "before";
}

/** The steps as they are made, and their end; `toUndo` leads to where it is undone. */
function steps(toUndo: () => void): {
  readonly root: HTMLElement;
  follow(commission: CommissionState): void;
  drop(): void;
} {
  const heading = new Strip({
    title: "Heading",
    quantity: "angle",
    isTall: true,
    isSteady: true,
    leastSpan: 0.5,
    curves: [
      { name: "measured", ink: "a" },
      { name: "asked for", ink: "b", dash: "dashed" },
    ],
  });
  const rudder = new Strip({
    title: "Rudder, share of full",
    quantity: "share",
    isSteady: true,
    leastSpan: 0.5,
    curves: [{ name: "", ink: "c" }],
  });
  const words = element("div", {});
  const said = element("ul", { class: "done", "aria-label": "What was done" });
  const measured = element("div", {});
  const charts = element(
    "section",
    { class: "panel stack" },
    element("h2", {}, "Heading steps"),
    heading.figure,
    rudder.figure,
  );
  const progress = element("section", { class: "panel stack" }, element("h2", {}, "What was done"), said, measured);
  const root = element(
    "div",
    { hidden: true },
    words,
    element("div", { class: "panels two spaced" }, charts, progress),
  );
  const seconds: number[] = [];
  const columns: [(number | null)[], (number | null)[], (number | null)[]] = [[], [], []];
  let next = 0;
  let timer = 0;
  let turned = 0;
  let dropped = false;
  let last: number | null = null;

  /** Without the jump from one turn to the next. */
  const unwrapped = (angle: number | null | undefined, near: number | null): number | null => {
    if (angle === null || angle === undefined) return null;
    return near === null ? angle : angle + 2 * Math.PI * Math.round((near - angle) / (2 * Math.PI));
  };
  let asking = false;
  const ask = async (): Promise<void> => {
    clearTimeout(timer);
    if (asking) return;
    asking = true;
    const found = await commissionSince(next).catch(() => null);
    asking = false;
    if (dropped) return;
    const commission = found?.commission ?? null;
    if (found !== null && commission !== null) {
      for (const sample of found.samples) {
        last = unwrapped(sample.heading_rad, last) ?? last;
        turned += 1;
        if (seconds.length >= MOST_POINTS && turned % 2 === 0) continue;
        seconds.push(sample.time_s);
        columns[0].push(sample.heading_rad == null ? null : last);
        columns[1].push(unwrapped(sample.wanted_rad, last));
        columns[2].push(sample.rudder ?? null);
      }
      next = found.next;
      const [first = 0] = seconds;
      const since = seconds.map((at) => at - first);
      heading.set(since, [columns[0], columns[1]]);
      rudder.set(since, [columns[2]]);
      tell(commission);
      if (!commission.running && found.samples.length === 0) return;
    }
    timer = window.setTimeout(() => void ask(), ASK_EVERY_MS);
  };
  const tell = (commission: CommissionState): void => {
    const [tone, loud] = commission.ended
      ? ENDS[commission.ended]
      : (["plain", "Heading steps are being made. The red button puts the old gains back."] as const);
    const isWarned = commission.needs_restoring;
    fill(
      words,
      element(
        "section",
        { class: `notice ${isWarned ? "bad" : tone}`, "aria-label": "What came of it", role: "status" },
        element("p", { class: "loud" }, loud),
        commission.line ? element("p", {}, sentence(commission.line.replace(/ To undo: .*/, ""))) : null,
        commission.undo || isWarned
          ? element("button", { type: "button", onclick: toUndo }, "Put the old gains back …")
          : null,
      ),
    );
    fill(said, ...commission.stages.map((text) => element("li", {}, sentence(text))));
    fill(
      measured,
      measurements(commission.old ?? null, commission.new ?? null),
      element("h3", {}, "Gains before and new"),
      gainsTable(commission.proposed.parameters, "before", inUse(commission)),
    );
    heading.describe(`Heading and the heading asked for over ${commission.stages.length} stages of the steps.`);
  };
  return {
    root,
    follow: (commission) => {
      root.hidden = false;
      if (commission.running) {
        next = 0;
        seconds.length = 0;
        for (const column of columns) column.length = 0;
        last = null;
      }
      tell(commission);
      void ask();
    },
    drop: () => {
      dropped = true;
      clearTimeout(timer);
      heading.drop();
      rudder.drop();
    },
  };
}
