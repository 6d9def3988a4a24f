//! Requests to the server. The types come from its OpenAPI document.

import type { Inspected } from "../views/inspected.ts";
import type { Models, Stated } from "../views/models.ts";
import type { components } from "./schema.ts";

type Schemas = components["schemas"];
export type Status = Schemas["Status"];
export type Control = Schemas["Control"];
export type Vehicles = Schemas["Vehicles"];
export type PlanOrder = Schemas["PlanOrder"];
export type PlanPreview = Schemas["PlanPreview"];
export type Preflight = Schemas["Preflight"];
export type TrialOrder = Schemas["TrialOrder"];
export type TrialState = Schemas["TrialState"];
export type RepeatOrder = Schemas["RepeatOrder"];
export type GoOnOrder = Schemas["GoOnOrder"];
export type RunSummary = Schemas["RunSummary"];
export type Verdict = Schemas["Verdict"];
export type VerdictOutcome = Schemas["VerdictOutcome"];
export type Figure = Schemas["Figure"];
export type Stage = Schemas["Stage"];
export type CampaignSummary = Schemas["CampaignSummary"];
export type CampaignDetail = Schemas["CampaignDetail"];
export type Comparison = Schemas["Comparison"];
export type Difference = Schemas["Difference"];
export type Schedule = Schemas["Schedule"];
export type CommissionOrder = Omit<Schemas["CommissionOrder"], "agreed"> & { agreed?: boolean };
export type CommissionPreview = Schemas["CommissionPreview"];
export type CommissionState = Schemas["CommissionState"];
export type CommissionShown = Schemas["CommissionShown"];
export type ExpectedSteps = Schemas["ExpectedSteps"];
export type MeasuredSteps = Schemas["MeasuredSteps"];
export type Series = Schemas["LogSeries"];
export type IdentifiedLog = Schemas["IdentifiedLog"];
export type LogColumns = Schemas["LogColumns"];
export type UndoOrder = Omit<Schemas["UndoOrder"], "agreed"> & { agreed?: boolean };
export type UndoPreview = Schemas["UndoPreview"];
export type Undone = Schemas["Undone"];
export type Plan = Record<string, unknown> & { thrusts: number[] };

const ROOT = "api/v1";
const TOKEN = "seatrial.token";
const LEASE = "seatrial.lease";

/** The server said no, or could not be reached: `code` is then `unreachable`. */
export class Refused extends Error {
  constructor(
    readonly code: string,
    message: string,
  ) {
    super(message);
  }
}

/** What proves who asks; kept until the tab is closed. */
export const secrets = {
  get token(): string | null {
    return sessionStorage.getItem(TOKEN);
  },
  set token(to: string | null) {
    keep(TOKEN, to);
  },
  get lease(): string | null {
    return sessionStorage.getItem(LEASE);
  },
  set lease(to: string | null) {
    keep(LEASE, to);
  },
};

function keep(key: string, value: string | null): void {
  if (value === null) sessionStorage.removeItem(key);
  else sessionStorage.setItem(key, value);
}

async function respond(method: string, path: string, body?: BodyInit, type?: string): Promise<Response> {
  const { token, lease } = secrets;
  const headers: Record<string, string> = { accept: "application/json" };
  if (token !== null) headers["authorization"] = `Bearer ${token}`;
  if (lease !== null) headers["seatrial-lease"] = lease;
  if (type !== undefined) headers["content-type"] = type;
  let response: Response;
  try {
    response = await fetch(`${ROOT}/${path}`, { method, headers, body: body ?? null, cache: "no-store" });
  } catch {
    throw new Refused("unreachable", "The server does not answer. Is it running, and is this device on its network?");
  }
  if (response.ok) return response;
  const refusal: unknown = await response.json().catch(() => null);
  if (typeof refusal === "object" && refusal !== null && "code" in refusal && "message" in refusal)
    throw new Refused(String(refusal.code), String(refusal.message));
  throw new Refused("refused", `The server answered ${response.status} ${response.statusText}.`);
}

async function ask<Answer>(method: string, path: string, body?: unknown): Promise<Answer> {
  const response = await (body === undefined
    ? respond(method, path)
    : respond(method, path, JSON.stringify(body), "application/json"));
  return response.status === 204 ? (undefined as Answer) : ((await response.json()) as Answer);
}

export const status = (): Promise<Status> => ask("GET", "status");
export const vehicles = (): Promise<Vehicles> => ask("GET", "vehicles");
export const defaultPlan = (): Promise<Plan> => ask("GET", "plans/default");
export const previewPlan = (order: PlanOrder): Promise<PlanPreview> => ask("POST", "plans/preview", order);
export const preflight = (order: PlanOrder): Promise<Preflight> => ask("POST", "preflight", order);
export const startTrial = (order: TrialOrder): Promise<TrialState> => ask("POST", "trial", order);
/** Nothing is answered where it was a commission. */
export const abortTrial = (): Promise<TrialState | undefined> => ask("POST", "trial/abort");
export const previewCommission = (order: CommissionOrder): Promise<CommissionPreview> =>
  ask("POST", "commission/preview", order);
export const startCommission = (order: CommissionOrder): Promise<CommissionState> => ask("POST", "commission", order);
export const commissionSince = (after: number): Promise<CommissionShown> => ask("GET", `commission?after=${after}`);
export const repeatSpeed = (order: RepeatOrder): Promise<TrialState> => ask("POST", "trial/repeat", order);
export const goOn = (order: GoOnOrder): Promise<TrialState> => ask("POST", "trial/go-on", order);
export const campaigns = (): Promise<CampaignSummary[]> => ask("GET", "campaigns");
export const campaign = (id: number): Promise<CampaignDetail> => ask("GET", `campaigns/${id}`);
export const seriesOf = (id: number, run: number): Promise<Series> => ask("GET", `campaigns/${id}/runs/${run}/series`);
export const compare = (a: number, b: number): Promise<Comparison> => ask("GET", `compare?a=${a}&b=${b}`);
export const reviewRun = (id: number, run: number, accepted: boolean, note: string): Promise<RunSummary> =>
  ask("POST", `campaigns/${id}/runs/${run}/review`, { accepted, note });

export function schedule(id: number, speed_m_s: number | null): Promise<Schedule> {
  return ask("GET", `campaigns/${id}/schedule${speed_m_s === null ? "" : `?speed_m_s=${speed_m_s}`}`);
}

export async function takeControl(name: string): Promise<void> {
  const { lease } = await ask<Schemas["Lease"]>("POST", "control", { name });
  secrets.lease = lease;
}

export async function giveControlBack(): Promise<void> {
  await ask<void>("DELETE", "control");
  secrets.lease = null;
}

/** Sends a log that a person has opened; `reading` are options of `seatrial identify` by name. */
async function sendLog(what: string, log: File, reading: Readonly<Record<string, string>>): Promise<Response> {
  const query = new URLSearchParams({ name: log.name, ...reading });
  return respond("POST", `logs/${what}?${query}`, log, "application/octet-stream");
}

export async function identify(log: File, reading: Readonly<Record<string, string>>): Promise<IdentifiedLog> {
  return (await (await sendLog("identify", log, reading)).json()) as IdentifiedLog;
}

/** What is in a log. */
export async function inspect(log: File, reading: Readonly<Record<string, string>>): Promise<Inspected> {
  return (await (await sendLog("inspect", log, reading)).json()) as Inspected;
}

/** The page of `seatrial report`. */
export async function reportOf(log: File, reading: Readonly<Record<string, string>>): Promise<Blob> {
  return (await sendLog("report", log, reading)).blob();
}

/** The track of a log that has latitude and longitude. */
export async function trackOf(
  log: File,
  reading: Readonly<Record<string, string>>,
  format: "gpx" | "kml",
): Promise<Blob> {
  return (await sendLog(`track/${format}`, log, reading)).blob();
}

/** The names of a log's columns, and the units that they may have. */
export async function columnsOf(log: File): Promise<LogColumns> {
  return (await (await sendLog("columns", log, {})).json()) as LogColumns;
}

/** A file that is made of models, with what to know of it. */
async function fileOf(response: Response): Promise<{ readonly blob: Blob; readonly notes: readonly string[] }> {
  const notes = response.headers.get("seatrial-notes") ?? "";
  return { blob: await response.blob(), notes: notes === "" ? [] : notes.split(" | ") };
}

/** What is made of the model of a log. */
export const modelsOfLog = (origin: string, document: IdentifiedLog["document"]): Models => ({
  limits: (stated) => ask("POST", "models/limits", { origin, document, stated }),
  file: async (name, stated) => {
    const order = JSON.stringify({ origin, document, stated });
    return fileOf(await respond("POST", `models/files/${name}`, order, "application/json"));
  },
});

/** What is made of the models of a campaign. */
export const modelsOfCampaign = (id: number): Models => {
  const query = (stated: Stated): URLSearchParams =>
    new URLSearchParams(Object.entries(stated).map(([name, value]) => [name, String(value)]));
  return {
    limits: (stated) => ask("GET", `campaigns/${id}/limits?${query(stated)}`),
    file: async (name, stated) => fileOf(await respond("GET", `campaigns/${id}/files/${name}?${query(stated)}`)),
  };
};

export const previewUndo = (order: UndoOrder): Promise<UndoPreview> => ask("POST", "commission/undo/preview", order);
export const undoCommission = (order: UndoOrder): Promise<Undone> => ask("POST", "commission/undo", order);

/** Sends a list of sensors, which logs of Slocum gliders need beside them. */
export async function sendSensorList(list: File): Promise<void> {
  const query = new URLSearchParams({ name: list.name });
  await respond("POST", `logs/sensor-list?${query}`, list, "application/octet-stream");
}

/** Saves a text under a name on this device. */
export function keepText(text: string, name: string): void {
  keepBlob(new Blob([text], { type: "application/octet-stream" }), name);
}

export function keepBlob(blob: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  URL.revokeObjectURL(link.href);
}

/** Saves a file of the server's under its name there. */
export async function download(path: string, name: string): Promise<void> {
  const response = await respond("GET", path);
  keepBlob(await response.blob(), name);
}
