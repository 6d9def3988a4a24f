//! Campaigns of the logbook, two of them compared, models over speed, and logs opened in the page.

import {
  type CampaignSummary,
  campaign,
  campaigns,
  columnsOf,
  type Comparison,
  compare,
  type Difference,
  download,
  identify,
  inspect,
  modelsOfCampaign,
  modelsOfLog,
  reportOf,
  sendSensorList,
  trackOf,
} from "../api/client.ts";
import type { Live } from "../api/live.ts";
import { pair } from "../charts/pair.ts";
import { element, fill } from "../element.ts";
import { Complaints } from "../notice.ts";
import type { View } from "../shell.ts";
import { onUnits, scale, shown, significant } from "../units.ts";
import { causes, percent, QUANTITIES, sentence, signOf, toneOf, word } from "../words.ts";
import { type LogReader, openLogView } from "./log.ts";
import { modelsPanel } from "./models.ts";
import { remarks } from "./remarks.ts";
import { figureCell, resume, runsTable } from "./runs.ts";
import { explorer } from "./schedule.ts";
import { commission } from "./start.ts";

const serverReader: LogReader = {
  identify,
  inspect,
  columnsOf,
  report: reportOf,
  track: trackOf,
  models: modelsOfLog,
  takeSensorList: sendSensorList,
  formats: "CSV, Parquet, DataFlash .bin, ULog, tlog, MCAP, rosbag, …",
  place: "It is identified by this server and goes nowhere else.",
};

const STATES: Record<CampaignSummary["state"], string> = {
  running: "running",
  finished: "finished",
  aborted: "aborted",
  interrupted: "interrupted",
};

/** `#/history`, `#/history/campaign/3`, `#/history/compare/3/4`, `#/history/log`. */
export function openHistory(_live: Live): View {
  const [, , tab = "", first, second] = location.hash.split("/");
  const complaints = new Complaints();
  const place = element("div", {});
  const drops: (() => void)[] = [];
  const link = (name: string, to: string, here: boolean): HTMLElement => {
    const anchor = element("a", { href: to }, name);
    if (here) anchor.setAttribute("aria-current", "page");
    return anchor;
  };
  const root = element(
    "div",
    {},
    element(
      "nav",
      { class: "tabs", "aria-label": "History" },
      link("Campaigns", "#/history", tab === "" || tab === "campaign" || tab === "compare"),
      link("Open a log", "#/history/log", tab === "log"),
    ),
    complaints.root,
    place,
  );
  const show = (): void => {
    if (tab === "campaign") void openCampaign(Number(first), place, complaints, drops);
    else if (tab === "compare") void openComparison(Number(first), Number(second), place, complaints);
    else void openList(place, complaints);
  };
  if (tab === "log") {
    const log = openLogView(serverReader);
    fill(place, log.root);
    return { root, drop: log.drop };
  }
  show();
  const forget = onUnits(show);
  return {
    root,
    drop: () => {
      forget();
      drops.forEach((drop) => drop());
    },
  };
}

/** The verdict on a campaign, which says more than how many of its runs were accepted. */
function verdictCell(outcome: CampaignSummary["verdict"]): HTMLElement {
  if (outcome == null) return element("td", { class: "words" }, "–");
  return element("td", { class: `words ${toneOf(outcome)}` }, `${signOf(outcome)} ${word(outcome)}`);
}

/** Asks for what a place shows; until there is something to see, says that it is being read. */
async function read<T>(place: HTMLElement, complaints: Complaints, work: () => Promise<T>): Promise<T | null> {
  const reading = element("p", { class: "notice", role: "status" }, "Reading the logbook …");
  if (place.childElementCount === 0) place.append(reading);
  const found = await complaints.hear(work);
  reading.remove();
  return found;
}

async function openList(place: HTMLElement, complaints: Complaints): Promise<void> {
  const all = await read(place, complaints, campaigns);
  if (all === null) return;
  if (all.length === 0) {
    fill(place, element("p", {}, "The logbook holds no campaign yet."));
    return;
  }
  // What is not to be used, or was cut short, is compared only where a person chooses it.
  const isRefused = (entry: CampaignSummary): boolean => entry.verdict === "do_not_use" || entry.verdict == null;
  const rank = (entry: CampaignSummary): number => (isRefused(entry) ? 2 : entry.state === "finished" ? 0 : 1);
  const newestFirst = [...all].reverse().sort((one, other) => rank(one) - rank(other));
  const [newest, before] = newestFirst;
  const chosen: [number, number] = [before?.id ?? 0, newest?.id ?? 0];
  const pick = (side: 0 | 1, name: string, entry: CampaignSummary): HTMLElement => {
    const radio = element("input", {
      type: "radio",
      name,
      value: entry.id,
      checked: chosen[side] === entry.id,
      "aria-label": `${name} campaign ${entry.id}`,
      onchange: () => (chosen[side] = entry.id),
    });
    return element("td", { class: "words" }, element("label", { class: "pick" }, radio));
  };
  const configurations = [...new Set(all.map((entry) => entry.configuration))];
  // What is chosen stands first: a phone shows it without a sideways scroll.
  const heads = ["campaign", "A", "B", "verdict", "vehicle", "began (UTC)", "state", "runs accepted"].map((name) =>
    element("th", { scope: "col", class: name === "runs accepted" ? "" : "words" }, name),
  );
  const groups = configurations.map((configuration) =>
    element(
      "tbody",
      {},
      element(
        "tr",
        {},
        element("th", { scope: "rowgroup", class: "words group", colspan: 8 }, `Configuration ${configuration}`),
      ),
      ...all
        .filter((entry) => entry.configuration === configuration)
        .reverse()
        .map((entry) =>
          element(
            "tr",
            {},
            element(
              "th",
              { scope: "row", class: "words" },
              element("a", { class: "touch", href: `#/history/campaign/${entry.id}` }, `No. ${entry.id}`),
            ),
            pick(0, "A", entry),
            pick(1, "B", entry),
            verdictCell(entry.verdict),
            element("td", { class: "words" }, entry.vehicle),
            element("td", { class: "words" }, entry.started.replace("T", " ").replace(/\.\d+|Z/g, "")),
            element(
              "td",
              { class: "words" },
              STATES[entry.state],
              entry.outcome && !entry.outcome.finished
                ? element("span", { class: "hint" }, `: ${entry.outcome.text}`)
                : null,
            ),
            element("td", {}, `${entry.runs_accepted} of ${entry.runs}`),
          ),
        ),
    ),
  );
  fill(
    place,
    element(
      "section",
      { class: "panel stack" },
      element("h2", {}, "Campaigns by configuration"),
      element(
        "div",
        { class: "table-box", tabindex: 0, role: "region", "aria-label": "Campaigns" },
        element("table", {}, element("thead", {}, element("tr", {}, ...heads)), ...groups),
      ),
      element(
        "div",
        { class: "row" },
        element(
          "button",
          {
            class: "main",
            type: "button",
            disabled: all.length < 2,
            onclick: () => (location.hash = `#/history/compare/${chosen[0]}/${chosen[1]}`),
          },
          "Compare A with B",
        ),
        element("p", { class: "hint" }, "What changed with the payload?"),
      ),
    ),
  );
}

async function openCampaign(
  id: number,
  place: HTMLElement,
  complaints: Complaints,
  drops: (() => void)[],
): Promise<void> {
  const detail = await read(place, complaints, () => campaign(id));
  if (detail === null) return;
  const { campaign: about } = detail;
  drops.splice(0).forEach((drop) => drop());
  const runs = runsTable(
    { campaign: id, seed: about.seed },
    detail.runs,
    () => void openCampaign(id, place, complaints, drops),
  );
  const facts: [string, string][] = [
    ["vehicle", about.vehicle],
    ["configuration", `${about.configuration}${about.notes ? `: ${about.notes}` : ""}`],
    ["began", about.started],
    ["state", `${STATES[about.state]}${about.outcome ? `: ${about.outcome.text}` : ""}`],
    ["largest rudder", shown(about.rudder_limit_rad, "angle")],
    ["seatrial", about.software_version],
    ["SHA-256", about.head_sha256],
  ];
  const file = (name: string, path: string, as: string): HTMLElement =>
    element(
      "button",
      { type: "button", onclick: () => void complaints.hear(() => download(`campaigns/${id}/${path}`, as)) },
      name,
    );
  const isRefused = detail.verdict.outcome === "do_not_use";
  // What is not to be used has no speed to be looked at.
  const scheduled = isRefused ? null : explorer(id, complaints);
  const isRehearsal = about.seed != null;
  const simulated = "The gains of a rehearsal are those of the simulated vehicle, not of yours.";
  const next = isRehearsal ? element("p", { class: "notice" }, simulated) : commission(about.vehicle, id);
  const hasModel = detail.counting_runs.length > 0;
  const endedEarly = about.state === "interrupted" || about.state === "aborted";
  drops.push(runs.drop);
  if (scheduled !== null) drops.push(scheduled.drop);
  fill(
    place,
    element(
      "div",
      { class: "panels two" },
      element(
        "section",
        { class: "panel wide stack" },
        element("h2", {}, `Campaign ${id}`),
        element(
          "section",
          { class: `notice ${toneOf(detail.verdict.outcome)}` },
          element(
            "p",
            { class: "loud" },
            `${signOf(detail.verdict.outcome)} ${sentence(word(detail.verdict.outcome))}`,
          ),
          ...causes({ ...detail.verdict, other_causes: 0 }).map((text) => element("p", {}, text)),
          remarks(detail.verdict, detail.reasons),
        ),
        endedEarly && resume({ campaign: id, seed: about.seed }, complaints),
        runs.root,
      ),
      scheduled?.root,
      hasModel
        ? element(
            "div",
            { class: "stack" },
            !isRefused && next,
            modelsPanel(modelsOfCampaign(id), {
              stem: `campaign-${id}`,
              isLog: false,
              isAgainst: isRefused,
              stated: { rehearsal: isRehearsal },
            }),
          )
        : null,
      element(
        "section",
        { class: "panel stack" },
        element("h2", {}, "Files"),
        element(
          "div",
          { class: "row" },
          file("Report, HTML", "report.html", `campaign-${id}.html`),
          file("Samples, CSV", "samples.csv", `campaign-${id}.csv`),
          file("Samples, MCAP", "samples.mcap", `campaign-${id}.mcap`),
        ),
        element("h3", {}, "About"),
        element(
          "dl",
          { class: "facts" },
          ...facts.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)]),
        ),
        element("details", {}, element("summary", {}, "Plan"), element("pre", {}, detail.plan)),
      ),
    ),
  );
}

async function openComparison(a: number, b: number, place: HTMLElement, complaints: Complaints): Promise<void> {
  const found = await read(place, complaints, () => compare(a, b));
  if (found === null) return;
  const changed = found.what_changed?.changed ?? null;
  const loud =
    changed === true
      ? "The vehicle has changed"
      : changed === false
        ? "No change that these data can tell"
        : "These data cannot tell whether the vehicle has changed";
  const isChanged = changed === true;
  const only = [
    ...found.only_in_a.map((thrust) => `${percent(thrust)} thrust only in A`),
    ...found.only_in_b.map((thrust) => `${percent(thrust)} thrust only in B`),
  ];
  fill(
    place,
    element(
      "section",
      { class: `notice ${changed === true ? "partly" : changed === false ? "good" : ""}` },
      element("p", { class: "loud" }, loud),
      ...(found.what_changed?.reasons ?? []).map((reason) => element("p", {}, sentence(reason.text))),
      only.length === 0 ? null : element("p", { class: "hint" }, `${only.join(", ")}.`),
    ),
    element(
      "p",
      {},
      element("b", {}, "A"),
      ` is campaign ${found.a.id}, ${found.a.configuration}; `,
      element("b", {}, "B"),
      ` is campaign ${found.b.id}, ${found.b.configuration}. Brackets are 95 % intervals; ▲ marks a change that is larger than its interval.`,
    ),
    element("div", { class: "panels compared" }, ...found.thrusts.map((at) => thrustPanel(at, isChanged))),
  );
}

function thrustPanel(at: Comparison["thrusts"][number], isChanged: boolean): HTMLElement {
  const [a = null, b = null] = at.surge_speed_m_s;
  const heads = [
    element("td", {}),
    element("th", { scope: "col" }, element("span", { class: "key key-a" }, "A")),
    element("th", { scope: "col" }, element("span", { class: "key key-b key-dashed" }, "B")),
    element("td", { class: "drawn" }),
    element("th", { scope: "col" }, "B − A"),
    element("th", { scope: "col" }, "÷ interval"),
  ];
  return element(
    "section",
    { class: "panel stack" },
    element("h2", {}, `${percent(at.thrust)} thrust, ${shown(a, "speed")} and ${shown(b, "speed")}`),
    element(
      "div",
      { class: "table-box", tabindex: 0, role: "region", "aria-label": `Differences at ${percent(at.thrust)} thrust` },
      element(
        "table",
        {},
        element("thead", {}, element("tr", {}, ...heads)),
        element("tbody", {}, ...at.differences.map((of) => differenceRow(of, isChanged))),
      ),
    ),
  );
}

/** Beyond 1 the difference is larger than chance makes it once in twenty times: it is marked where all together show a change. */
function differenceRow(of: Difference, isChanged: boolean): HTMLElement {
  const { name, quantity, unit } = QUANTITIES[of.quantity] ?? { name: of.quantity, quantity: "plain" };
  const { factor, unit: scaled } = scale(quantity);
  const isClear = isChanged && Math.abs(of.ratio ?? 0) > 1;
  return element(
    "tr",
    {},
    element("th", { scope: "row" }, name, element("span", { class: "interval" }, unit ?? scaled)),
    figureCell(of.a, factor),
    figureCell(of.b, factor),
    element("td", { class: "drawn" }, pair(of.a, of.b)),
    element("td", { class: isClear ? "strong" : "" }, significant(of.difference * factor, 2)),
    element(
      "td",
      { class: isClear ? "strong" : "" },
      of.ratio === null || of.ratio === undefined ? "–" : `${significant(of.ratio, 2)}${isClear ? " ▲" : ""}`,
    ),
  );
}
