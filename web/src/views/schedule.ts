//! Model, gains, margins and turning limits over speed, with a slider.

import { type Figure, type Schedule, schedule } from "../api/client.ts";
import { Strip } from "../charts/strip.ts";
import { element, fill, say } from "../element.ts";
import type { Complaints } from "../notice.ts";
import { onUnits, shown, significant, withInterval } from "../units.ts";

const SETTLED_MS = 80;
/** Steps of the slider from the slowest to the fastest identified speed. */
const STEPS = 200;

type Operating = NonNullable<Schedule["at"]>;

export function explorer(campaign: number, complaints: Complaints): { root: HTMLElement; drop(): void } {
  const slider = element("input", { type: "range", min: 0, max: STEPS, value: STEPS / 2 });
  const speed = element("output", {});
  const facts = element("dl", { class: "facts" }, element("dt", {}, "models"), element("dd", {}, "computing …"));
  const gain = new Strip({
    title: "Heading gain Kₚ",
    quantity: "plain",
    across: "speed",
    curves: [
      { name: "95 % interval", ink: "d", dash: "dotted" },
      { name: "", ink: "d", dash: "dotted" },
      { name: "", ink: "a" },
      { name: "identified", ink: "a", dash: "dots" },
      { name: "slider", ink: "b", dash: "dots" },
    ],
    band: [0, 1],
  });
  const radius = new Strip({
    title: "Steady turning radius",
    quantity: "distance",
    across: "speed",
    curves: [
      { name: "starboard", ink: "a" },
      { name: "port", ink: "b", dash: "dashed" },
      { name: "slider", ink: "b", dash: "dots" },
    ],
  });
  const root = element(
    "section",
    { class: "panel stack", "aria-label": "Schedule" },
    element("h2", {}, "At a speed of your choice"),
    element("label", { class: "field" }, element("span", {}, "Speed ", speed), slider),
    facts,
    gain.figure,
    radius.figure,
  );
  let known: Schedule | null = null;
  let timer = 0;

  const draw = (): void => {
    if (known === null) return;
    const points = known.points.filter((one) => typeof one.point.surge_speed_m_s === "number");
    const at = known.at ?? null;
    say(speed, shown(at?.surge_speed_m_s, "speed"));
    slider.setAttribute("aria-valuetext", speed.textContent ?? "");
    fill(facts, ...operatingFacts(at).flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)]));

    const rows = points.map(({ point }) => ({ x: point.surge_speed_m_s ?? 0, point, here: false }));
    if (at !== null && typeof at.surge_speed_m_s === "number")
      rows.push({ x: at.surge_speed_m_s, point: at, here: true });
    rows.sort((one, other) => one.x - other.x);
    const column = (of: (point: Operating) => number | null | undefined, here: boolean | null): (number | null)[] =>
      rows.map((row) => (here === null || row.here === here ? (of(row.point) ?? null) : null));
    const bound = (end: 0 | 1) => (point: Operating) => point.proportional_gain?.interval_95?.[end];
    const value = (point: Operating) => point.proportional_gain?.value;
    const turn = (side: 0 | 1) => (point: Operating) => point.steady_turning_radius_m[side]?.value;
    const seconds = rows.map((row) => row.x);
    gain.set(seconds, [
      column(bound(1), false),
      column(bound(0), false),
      column(value, null),
      column(value, false),
      column(value, true),
    ]);
    radius.set(seconds, [column(turn(0), null), column(turn(1), null), column(turn(0), true)]);
    gain.describe(
      `Kₚ ${significant(value(at ?? rows[0]?.point ?? ({} as Operating)) ?? NaN)} at ${speed.textContent}.`,
    );
    radius.describe(
      `Turning radius ${shown(at === null ? null : turn(0)(at), "distance")} to starboard at ${speed.textContent}.`,
    );
  };
  const ask = async (): Promise<void> => {
    const [slowest, fastest] = known?.speed_range_m_s ?? [];
    const wanted =
      slowest === undefined || fastest === undefined
        ? null
        : slowest + ((fastest - slowest) * slider.valueAsNumber) / STEPS;
    known = (await complaints.hear(() => schedule(campaign, wanted))) ?? known;
    if (known === null || known.points.length === 0) {
      fill(
        root,
        element("h2", {}, "At a speed of your choice"),
        element("p", {}, "No accepted run of this campaign has a model."),
      );
      return;
    }
    slider.disabled = !known.speed_range_m_s || known.points.length < 2;
    draw();
  };
  slider.addEventListener("input", () => {
    clearTimeout(timer);
    timer = window.setTimeout(() => void ask(), SETTLED_MS);
  });
  void ask().then(() => (known?.speed_range_m_s && known.points.length > 1 ? ask() : undefined));
  const forget = onUnits(draw);
  return {
    root,
    drop: () => {
      clearTimeout(timer);
      forget();
      gain.drop();
      radius.drop();
    },
  };
}

function operatingFacts(at: Operating | null): [string, string][] {
  if (at === null) return [["speed", "one identified speed only"]];
  const both = (pair: readonly (Figure | number | null)[], quantity: "distance" | "angular_rate" | "time"): string => {
    const [starboard, port] = pair.map((figure) =>
      shown(typeof figure === "number" ? figure : figure?.value, quantity),
    );
    return `${starboard} to starboard, ${port} to port`;
  };
  return [
    [
      "a₂₂, b₂, C₀",
      `${significant(at.a22_per_s)} 1/s, ${significant(at.b2_per_s2)} 1/s², ${significant(at.c0_rad_per_s2)} rad/s²`,
    ],
    ["Kₚ", at.no_gain ?? withInterval(at.proportional_gain?.value, at.proportional_gain?.interval_95)],
    ["rudder to go straight", shown(at.feed_forward_rudder_rad, "angle")],
    ["phase margin", shown(at.phase_margin_rad, "angle")],
    ["gain margin", typeof at.gain_margin === "number" ? `${significant(at.gain_margin)} times` : "unlimited"],
    ["delay margin", shown(at.delay_margin_s, "time")],
    ["overshoot", shown(at.overshoot, "share")],
    ["turning radius", both(at.steady_turning_radius_m, "distance")],
    ["yaw rate at most", both(at.yaw_rate_limit_rad_s, "angular_rate")],
    ["half turn takes", both(at.u_turn_time_s, "time")],
  ];
}
