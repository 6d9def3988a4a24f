//! What a controller, a simulator or a planner makes of models: gains, turning limits, files.

import { keepBlob, Refused } from "../api/client.ts";
import { element, fill, say } from "../element.ts";
import { bounded, shown, significant } from "../units.ts";
import { sentence } from "../words.ts";
import { type Cell, table } from "./inspected.ts";

type Estimate = { readonly value: number; readonly interval_95: readonly [number, number] | null } | null;

/** Options of `seatrial gains` and `export` by name. */
export type Stated = Readonly<Record<string, number | boolean>>;

/** A file that can be made of models. */
interface FileForm {
  readonly name: string;
  readonly label: string;
  readonly extension: string;
  readonly is_gains: boolean;
}

/** Gains and turning limits, what is said against them, and the files that can be made. */
export interface Limits {
  readonly files: readonly FileForm[];
  readonly warnings: readonly string[];
  /** Why no file of gains is written unless that is accepted. */
  readonly unusable: string | null;
  readonly gains: {
    readonly rudder_unit: string;
    readonly points: readonly {
      readonly thrust: number | null;
      readonly surge_speed_m_s: number | null;
      readonly refused: string | null;
      readonly proportional_gain: Estimate;
      readonly feed_forward_rudder_rad: Estimate;
      readonly loop: { readonly overshoot: Estimate; readonly phase_margin_rad: Estimate } | null;
    }[];
  };
  readonly turning: {
    readonly rudder_limit_rad: number;
    readonly points: readonly {
      readonly surge_speed_m_s: number | null;
      readonly hands: readonly {
        readonly hand: string;
        readonly refused: string | null;
        readonly yaw_rate_rad_s: Estimate;
        readonly u_turn_time_s: Estimate;
        readonly steady_turning_radius_m: Estimate;
      }[];
    }[];
  };
}

/** Who makes them: a server, or the page itself. */
export interface Models {
  limits(stated: Stated): Promise<Limits>;
  file(name: string, stated: Stated): Promise<{ readonly blob: Blob; readonly notes: readonly string[] }>;
}

export interface ModelsPlan {
  /** How the names of files begin. */
  readonly stem: string;
  /** Is it one model, whose speed a person may know better? */
  readonly isLog: boolean;
  /** A verdict against the models: no number is shown until that is read. */
  readonly isAgainst: boolean;
  /** The mean speed of the log, m/s: taken where the speed varies too much for the model to have one. */
  readonly meanSpeed_m_s?: number | null;
  /** What is always said, as that the models are those of a rehearsal. */
  readonly stated?: Stated;
  /** What does not work here. */
  readonly without?: readonly string[];
}

function estimateCell(estimate: Estimate): Cell {
  if (estimate === null || estimate.interval_95 === null) return significant(estimate?.value ?? NaN);
  const [value, low, high] = bounded(estimate.value, ...estimate.interval_95);
  return [value, `[${low}, ${high}]`];
}

export function modelsPanel(models: Models, plan: ModelsPlan): HTMLElement {
  const place = element(
    "div",
    { class: "stack" },
    element("p", { class: "hint", role: "status" }, "Computing gains and limits …"),
  );
  const told = element("p", { class: "hint", role: "status" });
  const buttons: HTMLButtonElement[] = [];
  /** Lets files be taken, or says in a line why none can be. */
  const close = (why: string | null): void => {
    for (const one of buttons) one.disabled = why !== null;
    say(told, why ?? "");
  };
  const accept = element("input", { type: "checkbox", onchange: () => void show() });
  const warning = element("div", { role: "alert" });
  const fields = formOf(plan.isLog, () => void show());
  const stated = (): Stated => ({
    ...plan.stated,
    ...fields.stated(),
    ...(accept.checked ? { accept: true } : {}),
  });
  /** What the terminal refuses without `--accept`, in the same words, with a box to take it. */
  const warn = (why: string | null): void =>
    fill(
      warning,
      why === null
        ? null
        : element(
            "div",
            { class: "notice partly" },
            element("p", {}, sentence(why)),
            element("label", { class: "choice" }, accept, "I have read this: show and write it all the same"),
          ),
    );
  const refuse = (error: unknown): void => {
    if (!(error instanceof Refused)) throw error;
    if (error.code === "gain_warned_of") warn(error.message);
    else fill(warning, element("div", { class: "notice bad" }, element("p", {}, error.message)));
  };
  const show = async (): Promise<void> => {
    try {
      const found = await models.limits(stated());
      offer(found.files);
      const hasNoSpeed = found.gains.points.some((point) => point.surge_speed_m_s === null);
      if (hasNoSpeed && fields.assume(plan.meanSpeed_m_s)) return show();
      warn(found.unusable);
      const isOpen = accept.checked || (found.unusable === null && !plan.isAgainst);
      fill(place, fields.assumed(), ...(plan.isAgainst && !isOpen ? [] : limitsShown(found)));
      close(isOpen ? null : "No file is written before you have read this and ticked the box above.");
    } catch (error) {
      fill(place);
      refuse(error);
      close("No file can be made of these models.");
    }
  };
  const keep = async ({ name, label, extension }: FileForm): Promise<void> => {
    say(told, `${label} …`);
    try {
      const { blob, notes } = await models.file(name, stated());
      keepBlob(blob, `${plan.stem}.${extension}`);
      say(told, [`${plan.stem}.${extension} is written.`, ...notes.map(sentence)].join(" "));
    } catch (error) {
      say(told, "");
      refuse(error);
    }
  };
  const button = (form: FileForm): HTMLElement => {
    const made = element("button", { type: "button", disabled: true, onclick: () => void keep(form) }, form.label);
    buttons.push(made);
    return made;
  };
  const ofGains = element("div", { class: "row" });
  const ofVehicle = element("div", { class: "stack" });
  /** Offers every file that can be made, once. */
  const offer = (files: readonly FileForm[]): void => {
    if (buttons.length > 0) return;
    const [vehicle, ...others] = files.filter((form) => !form.is_gains && plan.without?.includes(form.name) !== true);
    fill(ofGains, ...files.filter((form) => form.is_gains).map(button));
    fill(
      ofVehicle,
      element("div", { class: "row" }, vehicle !== undefined && button(vehicle)),
      element(
        "details",
        {},
        element("summary", {}, `${others.length} other forms`),
        element("div", { class: "row" }, ...others.map(button)),
      ),
    );
  };
  const root = element(
    "section",
    { class: "panel stack", "aria-label": "Gains and limits" },
    element("h2", {}, "Gains and limits"),
    warning,
    place,
    element("details", {}, element("summary", {}, "Choose damping, speed or rudder angle"), fields.root),
    element("h3", {}, "Parameters of a controller"),
    told,
    ofGains,
    element("h3", {}, "Vehicle for simulators and planners"),
    ofVehicle,
  );
  void show();
  return root;
}

interface ModelsForm {
  readonly root: HTMLElement;
  stated(): Stated;
  /** Takes a speed, m/s, where nobody has typed another. Is it taken only now? */
  assume(speed_m_s: number | null | undefined): boolean;
  /** What is said of a speed that was taken so. */
  assumed(): HTMLElement | null;
}

function formOf(isLog: boolean, changed: () => void): ModelsForm {
  const speed = element("input", { name: "surge_speed_m_s", type: "number", step: "any", min: 0 });
  let taken: number | null = null;
  const number = (label: string, name: string): HTMLElement =>
    element("label", { class: "field" }, label, element("input", { name, type: "number", step: "any", min: 0 }));
  const root = element(
    "form",
    { class: "fields", onsubmit: (event: Event) => (event.preventDefault(), changed()), onchange: changed },
    number("Damping ratio of the loop", "damping_ratio"),
    isLog && element("label", { class: "field" }, "Forward speed, m/s, where the log has none", speed),
    number("Largest rudder angle, °", "rudder_limit_deg"),
    number("Rudder at full steering, °", "full_rudder_deg"),
    number("Parameters at the speed, m/s", "at_speed_m_s"),
  );
  return {
    root,
    stated: () => {
      const given = [...new FormData(root)].filter(([, value]) => value !== "");
      return Object.fromEntries(given.map(([name, value]) => [name, Number(value)]));
    },
    assume: (speed_m_s) => {
      if (speed_m_s == null || taken !== null || speed.value !== "") return false;
      taken = speed_m_s;
      speed.valueAsNumber = speed_m_s;
      return true;
    },
    assumed: () =>
      taken === null || speed.valueAsNumber !== taken
        ? null
        : element(
            "p",
            { class: "hint" },
            `The speed of the log varies. Its mean is taken, ${shown(taken, "speed")}: radii and files are for it. Another one can be typed below.`,
          ),
  };
}

function limitsShown({ warnings, gains, turning }: Limits): HTMLElement[] {
  const speed = (point: { readonly surge_speed_m_s: number | null }): string => shown(point.surge_speed_m_s, "speed");
  const degrees = (estimate: Estimate): string => shown(estimate?.value, "angle");
  const rudder = gains.rudder_unit === "rad" ? "angle" : "share";
  return [
    ...warnings.map((one) => element("p", { class: "hint" }, sentence(one))),
    table(
      "Gains",
      ["speed", "Kₚ", "overshoot", "phase margin", "rudder to go straight"],
      gains.points.map((point) =>
        point.refused === null
          ? [
              speed(point),
              estimateCell(point.proportional_gain),
              shown(point.loop?.overshoot?.value, "share"),
              degrees(point.loop?.phase_margin_rad ?? null),
              shown(point.feed_forward_rudder_rad?.value, rudder),
            ]
          : [speed(point), `none: ${point.refused}`, "–", "–", "–"],
      ),
    ),
    table(
      `Turning with ${shown(turning.rudder_limit_rad, rudder)} of rudder`,
      ["speed", "to", "yaw rate", "U-turn", "radius"],
      turning.points.flatMap((point) =>
        point.hands.map((one) => [
          speed(point),
          one.refused === null ? one.hand : `${one.hand}: ${one.refused}`,
          shown(one.yaw_rate_rad_s?.value, "angular_rate"),
          shown(one.u_turn_time_s?.value, "time"),
          shown(one.steady_turning_radius_m?.value, "distance"),
        ]),
      ),
    ),
  ];
}
