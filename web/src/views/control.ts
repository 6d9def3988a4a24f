//! Prepare, preview, check and start a trial; who has control.

import {
  campaign,
  defaultPlan,
  giveControlBack,
  type Plan,
  type PlanPreview,
  type Preflight,
  preflight,
  previewPlan,
  startTrial,
  status,
  takeControl,
  type TrialState,
  vehicles,
  type Vehicles,
} from "../api/client.ts";
import { type Live, relativeHalfWidth } from "../api/live.ts";
import { Track } from "../charts/track.ts";
import { element, fill, say } from "../element.ts";
import { Complaints } from "../notice.ts";
import type { View } from "../shell.ts";
import { clock, onUnits, shown, significant } from "../units.ts";
import { percent } from "../words.ts";
import { checklist } from "./checks.ts";
import { runsTable } from "./runs.ts";

const NAME = "seatrial.name";
/** Control lapses when its holder was silent for so long. */
const LAPSES_AFTER_S = 60;
const ASK_AGAIN_MS = 1000;
/** A check of a vehicle that may have moved since then is made again. */
const CHECK_HOLDS_MS = 600_000;
const SPEEDS: readonly [string, number | null][] = [
  ["real time", 1],
  ["real time × 10", 10],
  ["as fast as it can", null],
];

/** The last check, with what it was of: it holds while that is the same. */
let checked: { readonly of: string; readonly found: Preflight; readonly at_ms: number } | null = null;

export function openControl(live: Live): View {
  const complaints = new Complaints();
  const holder = holderPanel(live);
  const trial = trialForm(live, complaints);
  const runs = element("section", { class: "panel wide", "aria-label": "Runs of the trial" });
  let shownRuns = "";
  let table: ReturnType<typeof runsTable> | null = null;

  const draw = (): void => {
    holder.draw();
    trial.draw();
    const now = live.trial;
    const key = JSON.stringify([now?.campaign, now?.running, now?.runs]);
    if (key !== shownRuns) {
      shownRuns = key;
      runs.hidden = now === null || now.runs.length === 0;
      table?.drop();
      table = now === null ? null : runsTable(now, now.runs, () => void refresh(now));
      const which =
        now?.running === true ? "this trial" : `the last trial: ${now?.vehicle ?? ""}, ${now?.configuration ?? ""}`;
      fill(runs, element("h2", {}, `Runs of ${which}`), table?.root);
    }
  };
  /** A review is not in the live stream: the runs are asked for again. */
  const refresh = async (of: TrialState): Promise<void> => {
    const detail = await complaints.hear(() => campaign(of.campaign));
    if (detail !== null) of.runs = detail.runs;
    draw();
  };
  const unwatch = live.watch(draw);
  draw();
  return {
    root: element(
      "div",
      {},
      complaints.root,
      element(
        "div",
        { class: "panels aside" },
        element("div", { class: "column" }, holder.root, trial.form),
        element("div", { class: "column" }, trial.expectation),
        runs,
      ),
    ),
    drop: () => {
      unwatch();
      table?.drop();
      trial.drop();
      holder.drop();
    },
  };
}

function holderPanel(live: Live): { root: HTMLElement; draw(): void; drop(): void } {
  const complaints = new Complaints();
  const words = element("p", { role: "status" });
  const name = element("input", { maxlength: 64, required: true, autocomplete: "name" });
  name.value = localStorage.getItem(NAME) ?? "";
  const take = async (event: Event): Promise<void> => {
    event.preventDefault();
    localStorage.setItem(NAME, name.value);
    await complaints.hear(() => takeControl(name.value));
    live.open();
  };
  const back = async (): Promise<void> => {
    await complaints.hear(giveControlBack);
    live.open();
  };
  // Who comes back without the lease waits until it lapses, which others can see.
  let waiting = 0;
  const stopWaiting = (): void => {
    clearInterval(waiting);
    waiting = 0;
  };
  const takeNow = async (): Promise<void> => {
    stopWaiting();
    await complaints.hear(() => takeControl(name.value));
    live.open();
  };
  const wait = (): void => {
    if (waiting !== 0 || !root.reportValidity()) return;
    localStorage.setItem(NAME, name.value);
    waiting = window.setInterval(() => void askAgain(), ASK_AGAIN_MS);
    void askAgain();
  };
  const askAgain = async (): Promise<void> => {
    const found = await complaints.hear(status);
    if (found === null || waiting === 0) return;
    const { holder, silent_for_s: silent } = found.control;
    if (holder === null || holder === undefined) return takeNow();
    const left = Math.max(0, Math.ceil(LAPSES_AFTER_S - (silent ?? 0)));
    say(
      words,
      `${holder} was last heard ${Math.round(silent ?? 0)} s ago. Control is yours in ${left} s, unless ${holder} is heard.`,
    );
  };
  const waitButton = element("button", { type: "button", onclick: wait }, "Take over when it lapses");
  const takeButton = element("button", { class: "main", type: "submit" }, "Take control");
  const backButton = element("button", { type: "button", onclick: () => void back() }, "Give control back");
  const root = element(
    "form",
    { class: "panel stack", onsubmit: (event: Event) => void take(event) },
    element("h2", {}, "Who has control"),
    words,
    complaints.root,
    element("label", { class: "field" }, "Your name", name),
    element("div", { class: "row" }, takeButton, waitButton, backButton),
    element(
      "p",
      { class: "hint" },
      "Others are told your name. Control lapses a minute after this page was last heard. The red button works for every operator.",
    ),
  );
  return {
    root,
    draw: () => {
      const { control } = live;
      const isOthers = typeof control?.holder === "string" && !control.is_you;
      if (waiting !== 0 && control && !isOthers) void (control.holder ? stopWaiting() : takeNow());
      if (waiting === 0)
        say(
          words,
          control?.holder
            ? control.is_you
              ? `You have control, as ${control.holder}.`
              : `${control.holder} has control.`
            : "Nobody has control.",
        );
      takeButton.hidden = isOthers;
      waitButton.hidden = !isOthers;
      takeButton.disabled = control?.is_you === true;
      backButton.disabled = control?.is_you !== true;
    },
    drop: stopWaiting,
  };
}

interface TrialForm {
  form: HTMLElement;
  expectation: HTMLElement;
  draw(): void;
  drop(): void;
}

function trialForm(live: Live, complaints: Complaints): TrialForm {
  const vehicle = element("select", {});
  const about = element("span", { class: "hint" });
  const planFile = element("input", { class: "unseen", type: "file", accept: ".json,application/json" });
  const planName = element("p", { class: "hint", role: "status" });
  // Until there is a plan to change.
  const thrusts = element("input", { inputmode: "text", required: true, disabled: true });
  const repeats = element("input", { type: "number", min: 0, max: 10, required: true });
  const configuration = element("input", { maxlength: 200, value: "default", required: true });
  const note = element("textarea", { rows: 2, maxlength: 4000 });
  const seed = element("input", { type: "number", min: 0, step: 1, value: 1 });
  const pace = element("select", {}, ...SPEEDS.map(([name], at) => element("option", { value: at }, name)));
  const agreed = element("input", { type: "checkbox" });
  const scenario = element("select", {}, element("option", { value: "" }, "none"));
  const faults = element("span", { class: "hint" });
  const simulated = element(
    "div",
    { class: "stack" },
    element("label", { class: "field" }, "Fault to rehearse", scenario, faults),
    element(
      "div",
      { class: "row" },
      element("label", { class: "field" }, "Seed of noise and sea", seed),
      element("label", { class: "field" }, "Pace", pace),
    ),
  );
  const moving = element(
    "label",
    { class: "choice" },
    agreed,
    "I agree that this vehicle moves and that its parameters are changed until it is handed back",
  );
  const start = element("button", { class: "main", type: "submit" }, "Start the trial");
  const why = element("p", { class: "hint", role: "status" });
  const expectation = element("section", {
    class: "panel stack",
    "aria-label": "What to expect",
    "aria-live": "polite",
  });
  const checklist = element("section", {
    class: "stack",
    "aria-label": "Preflight checklist",
    "aria-live": "polite",
  });
  const track = new Track("Room that it needs");
  const none = element(
    "p",
    { class: "notice partly", hidden: true },
    "This server knows simulated vehicles only. Start it with yours, as in: seatrial serve --vehicle mavlink:udp:0.0.0.0:14550",
  );

  let known: Vehicles["vehicles"] = [];
  let plan: Plan | null = null;
  let ready: boolean | null = null;
  let previewed: PlanPreview | null = null;
  const chosen = (): Vehicles["vehicles"][number] | undefined => known.find((one) => one.name === vehicle.value);
  const order = (): { vehicle: string; plan: never } => ({ vehicle: vehicle.value, plan: plan as never });

  const checking = element("p", { role: "status" });
  const checkButton = element("button", { type: "button", onclick: () => void check() }, "Check the vehicle");
  const unchecked = [element("h2", {}, "Preflight"), checking, element("div", { class: "row" }, checkButton)];

  /** What a check is of: repeats change nothing of it. */
  const checkedOf = (): string => JSON.stringify({ ...order(), plan: { ...plan, max_repeats: null } });
  const unsettled = (): void => {
    if (checked?.of === checkedOf() && Date.now() - checked.at_ms < CHECK_HOLDS_MS) {
      ready = checked.found.ready;
      drawChecklist(checklist, checked.found, () => void check());
      draw();
      return;
    }
    ready = null;
    say(checking, "Not checked yet.");
    checkButton.disabled = plan === null;
    // A button that is replaced while it is pressed is not pressed.
    if (!checkButton.isConnected) fill(checklist, ...unchecked);
    draw();
  };
  const check = async (): Promise<void> => {
    say(checking, "Looking at the vehicle. This takes up to 20\u00a0s for an autopilot.");
    const found = await complaints.hear(() => preflight(order()));
    if (found === null) return unsettled();
    ready = found.ready;
    checked = { of: checkedOf(), found, at_ms: Date.now() };
    drawChecklist(checklist, found, () => void check());
    draw();
  };
  const look = async (): Promise<void> => {
    if (plan !== null) plan = { ...plan, thrusts: parsedThrusts(thrusts.value), max_repeats: repeats.valueAsNumber };
    unsettled();
    if (plan === null) return;
    if (chosen()?.is_simulated === false) {
      previewed = null;
      fill(
        expectation,
        element("h2", {}, "What to expect"),
        element(
          "p",
          {},
          "How this vehicle steers is not known before its first trial. Try the plan on a simulated one first.",
        ),
      );
      return;
    }
    const found = await complaints.hear(() => previewPlan(order()));
    if (found === null)
      fill(
        expectation,
        element("h2", {}, "What to expect"),
        element("p", {}, "This plan could not be previewed on this vehicle."),
      );
    else drawExpectation(expectation, track, found);
    previewed = found;
  };
  const adopt = (adopted: Plan, name: string): void => {
    plan = adopted;
    thrusts.disabled = false;
    thrusts.value = adopted.thrusts.map((thrust) => `${+(100 * thrust).toPrecision(3)}`).join(", ");
    repeats.valueAsNumber = Number(adopted["max_repeats"] ?? 2);
    say(planName, name);
    void look();
  };
  const changeVehicle = async (): Promise<void> => {
    const one = chosen();
    say(about, one?.description ?? "");
    simulated.hidden = one?.is_simulated === false;
    moving.hidden = one?.is_simulated !== false;
    const suggested = await complaints.hear(defaultPlan);
    if (suggested !== null) adopt(suggested, "The plan is the default one, the paper's.");
  };
  const openPlan = async (): Promise<void> => {
    const file = planFile.files?.[0];
    if (file === undefined) return;
    try {
      const read: unknown = JSON.parse(await file.text());
      if (typeof read !== "object" || read === null || !("thrusts" in read) || !Array.isArray(read.thrusts))
        throw new SyntaxError("it has no thrusts");
      adopt(read as Plan, `The plan is ${file.name}.`);
    } catch (error) {
      say(
        planName,
        `${file.name} is not a plan: ${error instanceof Error ? error.message : String(error)}. Expected the JSON that seatrial plan --json prints.`,
      );
    }
  };
  const begin = async (event: Event): Promise<void> => {
    event.preventDefault();
    const one = chosen();
    const started = await complaints.hear(() =>
      startTrial({
        ...order(),
        configuration: configuration.value,
        note: note.value === "" ? null : note.value,
        agreed: agreed.checked,
        ...(one?.is_simulated === true
          ? {
              scenario: scenario.value === "" ? null : scenario.value,
              seed: seed.valueAsNumber,
              realtime_factor: SPEEDS[Number(pace.value)]?.[1] ?? null,
            }
          : {}),
      }),
    );
    if (started !== null) location.hash = "#/live";
  };
  vehicle.addEventListener("change", () => void changeVehicle());
  thrusts.addEventListener("change", () => void look());
  repeats.addEventListener("change", () => void look());
  agreed.addEventListener("change", () => draw());
  planFile.addEventListener("change", () => void openPlan());

  const form = element(
    "form",
    { class: "panel stack", onsubmit: (event: Event) => void begin(event) },
    element("h2", {}, "Trial"),
    none,
    element("label", { class: "field" }, "Vehicle", vehicle, about),
    planName,
    element("label", { class: "file" }, "Plan from a file", planFile),
    element("label", { class: "field" }, "Speeds, thrust in % of full", thrusts),
    element("label", { class: "field" }, "Repeats of a speed that is rejected", repeats),
    element("label", { class: "field" }, "Configuration (payload)", configuration),
    element("label", { class: "field" }, "Notes", note),
    simulated,
    checklist,
    moving,
    why,
    element("div", { class: "row" }, start),
  );
  const draw = (): void => {
    const obstacle =
      live.trial?.running === true || live.commission?.running === true
        ? `A ${live.trial?.running === true ? "trial" : "commission"} is running.`
        : live.control?.is_you !== true
          ? "Take control first."
          : ready === null
            ? "Check the vehicle first."
            : !ready
              ? "The preflight check has not passed."
              : chosen()?.is_simulated === false && !agreed.checked
                ? "Agree that the vehicle moves."
                : "";
    start.disabled = obstacle !== "";
    say(why, obstacle);
  };

  void complaints.hear(vehicles).then((answer) => {
    if (answer === null) return;
    known = answer.vehicles;
    for (const one of answer.scenarios) {
      const name = one.name.replaceAll("_", " ");
      scenario.append(element("option", { value: one.name, title: one.description }, name));
    }
    scenario.addEventListener("change", () => say(faults, scenario.selectedOptions[0]?.title ?? ""));
    fill(vehicle, ...known.map((one) => element("option", { value: one.name }, one.name)));
    const [, , wish] = location.hash.split("/");
    const wished = known.find((one) => one.is_simulated === (wish === "rehearse"));
    if (wish !== undefined && wished !== undefined) vehicle.value = wished.name;
    if (wish === "rehearse") pace.value = "1"; // Half a minute in place of four.
    none.hidden = wish !== "trial" || wished !== undefined;
    void changeVehicle();
  });
  fill(expectation, element("h2", {}, "What to expect"), element("p", {}, "No plan yet."));
  unsettled();
  const forget = onUnits(() => previewed !== null && drawExpectation(expectation, track, previewed));
  return {
    form,
    expectation,
    draw,
    drop: () => {
      forget();
      track.drop();
    },
  };
}

function parsedThrusts(text: string): number[] {
  return text
    .split(/[\s,;%]+/)
    .filter((part) => part !== "")
    .map((part) => Number(part) / 100);
}

function drawExpectation(place: HTMLElement, track: Track, found: PlanPreview): void {
  track.set({ track: [[0, 0]], area: [], box: found.track_box_m ?? null, heading_rad: null });
  const width = (figure: Parameters<typeof relativeHalfWidth>[0] | undefined): string => {
    const relative = figure === undefined ? null : relativeHalfWidth(figure);
    return relative === null ? "–" : `±\u202f${significant(100 * relative, 2)}\u00a0%`;
  };
  const rows = found.speeds.map((speed) =>
    element(
      "tr",
      {},
      element("th", { scope: "row" }, percent(speed.thrust)),
      element(
        "td",
        { class: speed.expected?.is_enough === true ? "good" : "bad" },
        speed.expected?.is_enough === true ? "✓ yes" : "✗ no",
      ),
      element("td", {}, shown(speed.surge_speed_m_s, "speed")),
      element("td", {}, clock(speed.stages_s.reduce((sum, stage) => sum + stage, 0))),
      element("td", {}, shown(speed.heading_excursion_rad, "angle", 2)),
      element("td", {}, width(speed.expected?.a22_per_s)),
      element("td", {}, width(speed.expected?.b2_per_s2)),
    ),
  );
  const heads = ["thrust", "enough", "speed", "time", "heading", "a₂₂", "b₂"].map((name) =>
    element("th", { scope: "col" }, name),
  );
  const aborted = found.outcome && !found.outcome.finished ? found.outcome.text : null;
  fill(
    place,
    element("h2", {}, "What to expect"),
    aborted === null
      ? null
      : element(
          "div",
          { class: "notice bad" },
          element("p", {}, `Even a vehicle without noise would abort: ${aborted}`),
        ),
    element(
      "p",
      {},
      `${clock(found.duration_s)} min, at most ${clock(found.longest_s)} min without repeats. ${found.is_enough ? "At every speed the manoeuvre is strong enough for a usable model." : "At some speeds the manoeuvre is too weak for a usable model."}`,
    ),
    found.track_box_m ? track.figure : null,
    element(
      "p",
      { class: "hint" },
      "enough: is the model precise enough for gains? a₂₂ and b₂: how far, at best, the 95 % interval reaches to either side",
    ),
    element(
      "div",
      { class: "table-box", tabindex: 0, role: "region", "aria-label": "Expected intervals" },
      element("table", {}, element("thead", {}, element("tr", {}, ...heads)), element("tbody", {}, ...rows)),
    ),
  );
}

function drawChecklist(place: HTMLElement, found: Preflight, again: () => void): void {
  const changes = found.changes.map((change) =>
    element("li", {}, `${change.name}: ${significant(change.from)} → ${significant(change.to)}. ${change.why}`),
  );
  fill(
    place,
    element("h2", {}, "Preflight"),
    element(
      "p",
      {},
      element("span", { class: `badge ${found.ready ? "good" : "bad"}` }, found.ready ? "✓ ready" : "✗ not ready"),
    ),
    checklist(found.checks),
    changes.length === 0 ? null : element("h3", {}, "Changed until it is handed back"),
    changes.length === 0 ? null : element("ul", {}, ...changes),
    element("div", { class: "row" }, element("button", { type: "button", onclick: again }, "Check again")),
  );
}
