//! What a controller makes of a model: gains, turning limits, files of parameters.

import { type IdentifiedLog, keepText } from "../api/client.ts";
import { element, fill } from "../element.ts";
import { Complaints } from "../notice.ts";
import { shown, withInterval } from "../units.ts";
import { table } from "./found.ts";
import type { Program } from "./module.ts";

type Estimate = { readonly value: number; readonly interval_95: readonly [number, number] | null } | null;

interface Answer {
  readonly gains: {
    readonly points: readonly {
      readonly thrust: number | null;
      readonly surge_speed_m_s: number | null;
      readonly refused: string | null;
      readonly proportional_gain: Estimate;
      readonly loop: { readonly overshoot: Estimate; readonly phase_margin_rad: Estimate } | null;
    }[];
  };
  readonly turning: {
    readonly points: readonly {
      readonly surge_speed_m_s: number | null;
      readonly hands: readonly {
        readonly hand: string;
        readonly yaw_rate_rad_s: Estimate;
        readonly u_turn_time_s: Estimate;
        readonly steady_turning_radius_m: Estimate;
      }[];
    }[];
  };
}

const FILES: readonly (readonly [form: string, label: string, suffix: string])[] = [
  ["ardupilot_surface", "ArduPilot Rover", "param"],
  ["ardupilot_underwater", "ArduPilot Sub", "param"],
  ["px4_surface", "PX4 rover", "params"],
  ["px4_underwater", "PX4 UUV", "params"],
  ["ros2", "ROS 2", "yaml"],
  ["c", "C header", "h"],
];

const text = (estimate: Estimate): string =>
  estimate === null ? "–" : withInterval(estimate.value, estimate.interval_95 ?? undefined);

export function controllers(program: Program, name: string, found: IdentifiedLog): HTMLElement {
  const stem = name.replace(/\.\w+$/, "");
  const complaints = new Complaints();
  const place = element("div", { class: "stack" });
  const number = (label: string, field: string): [string, HTMLElement] => [
    field,
    element("label", { class: "field" }, label, element("input", { name: field, type: "number", step: "any", min: 0 })),
  ];
  const fields = [
    number("Damping ratio of the loop", "damping_ratio"),
    number("Forward speed, m/s, where the log has none", "surge_speed_m_s"),
    number("Rudder at full steering, °", "full_rudder_deg"),
  ];
  const form = element(
    "form",
    { class: "fields", onsubmit: (event: Event) => (event.preventDefault(), void show()), onchange: () => void show() },
    ...fields.map(([, field]) => field),
  );
  const request = (): object => {
    const given = [...new FormData(form)].filter(([, value]) => value !== "");
    const stated = Object.fromEntries(given.map(([field, value]) => [field, Number(value)]));
    return { origin: name, document: found.document, stated };
  };
  const show = async (): Promise<void> => {
    const answer = await complaints.hear(() => program.ask<Answer>({ ask: "gains", ...request() }));
    fill(place, ...(answer === null ? [] : tables(answer)));
  };
  const keep = async (file: string, suffix: string): Promise<void> => {
    const answer = await complaints.hear(() =>
      program.ask<{ text: string }>({ ask: "file", ...request(), form: file }),
    );
    if (answer !== null) keepText(answer.text, `${stem}.${suffix}`);
  };
  void show();
  return element(
    "section",
    { class: "panel stack", "aria-label": "Gains and limits" },
    element("h2", {}, "Gains and limits"),
    form,
    place,
    element("h3", {}, "Files of parameters"),
    element(
      "div",
      { class: "row" },
      ...FILES.map(([file, label, suffix]) =>
        element("button", { type: "button", onclick: () => void keep(file, suffix) }, label),
      ),
    ),
    complaints.root,
  );
}

function tables({ gains, turning }: Answer): HTMLElement[] {
  const speed = (point: { readonly surge_speed_m_s: number | null }): string => shown(point.surge_speed_m_s, "speed");
  const degrees = (estimate: Estimate): string => shown(estimate?.value, "angle");
  return [
    table(
      "Gains",
      ["speed", "K_p", "overshoot", "phase margin"],
      gains.points.map((point) =>
        point.refused === null
          ? [
              speed(point),
              text(point.proportional_gain),
              shown(point.loop?.overshoot?.value, "share"),
              degrees(point.loop?.phase_margin_rad ?? null),
            ]
          : [speed(point), `none: ${point.refused}`, "–", "–"],
      ),
    ),
    table(
      "Turning under full rudder",
      ["speed", "to", "yaw rate", "U-turn", "radius"],
      turning.points.flatMap((point) =>
        point.hands.map((one) => [
          speed(point),
          one.hand,
          shown(one.yaw_rate_rad_s?.value, "angular_rate"),
          shown(one.u_turn_time_s?.value, "time"),
          shown(one.steady_turning_radius_m?.value, "distance"),
        ]),
      ),
    ),
  ];
}
