//! What the page knows of the trial that runs: the live stream, kept up through lost connections.

import {
  type CommissionState,
  type Control,
  type Figure,
  secrets,
  type Stage,
  status,
  type TrialState,
} from "./client.ts";
import type { components } from "./schema.ts";

type Schemas = components["schemas"];
type Message = Schemas["LiveMessage"];
type Snapshot = Schemas["Snapshot"];
type Sample = Schemas["LiveSample"];
type Estimate = Schemas["EstimateNow"];
type Envelope = Schemas["Envelope"];
type Health = Schemas["Health"];

/** Points of a chart; of a longer run every second one is dropped. */
const MOST_POINTS = 6000;
const FIRST_RETRY_MS = 500;
const LAST_RETRY_MS = 8000;
/** Heartbeats that may be missed before the connection counts as lost. */
const PATIENCE = 2.5;
/** While a trial runs its health is told every second. */
const PATIENCE_RUNNING_S = 3;

export interface StageStretch {
  stage: Stage;
  from_s: number;
  to_s: number;
}

/** Columns of the present run, SI, headings without jumps. */
export interface Columns {
  time_s: number[];
  heading_rad: (number | null)[];
  simulated_heading_rad: (number | null)[];
  yaw_rate_rad_s: (number | null)[];
  rudder_rad: (number | null)[];
  surge_speed_m_s: (number | null)[];
  depth_m: (number | null)[];
}

export type Connection = "connecting" | "open" | "lost" | "refused";

export class Live {
  connection: Connection = "connecting";
  /** Why the server would not speak. */
  refusal: string | null = null;
  control: Control | null = null;
  trial: TrialState | null = null;
  commission: CommissionState | null = null;
  envelope: Envelope | null = null;
  health: Health | null = null;
  samples: Columns = noColumns();
  estimates: Estimate[] = [];
  stages: StageStretch[] = [];
  track_m: [number, number][] = [];
  private socket: WebSocket | null = null;
  private stream: string | null = null;
  private sequence: number | null = null;
  private retry_ms = FIRST_RETRY_MS;
  private heartbeat_s = 5;
  private timer = 0;
  private heard_ms = 0;
  private lastHeading: number | null = null;
  private readonly watchers = new Set<() => void>();

  /** Calls back when something changed. */
  watch(callback: () => void): () => void {
    this.watchers.add(callback);
    return () => this.watchers.delete(callback);
  }

  /** Opens the stream, also a second time with other secrets. */
  open(): void {
    clearTimeout(this.timer);
    const old = this.socket;
    this.socket = null;
    old?.close();
    const url = new URL("api/v1/live", location.href);
    url.protocol = url.protocol.replace("http", "ws");
    url.hash = "";
    const socket = new WebSocket(url);
    this.socket = socket;
    socket.onopen = () => {
      const resume = this.stream === null ? {} : { stream: this.stream, after: this.sequence };
      socket.send(JSON.stringify({ token: secrets.token, lease: secrets.lease, ...resume }));
      // A stream that goes on where it was has nothing to say until something happens.
      if (this.stream !== null) {
        this.connection = "open";
        if (this.control !== null) this.learnControl(this.control);
      }
      this.tell();
      this.listen();
    };
    socket.onmessage = (frame) => {
      if (socket !== this.socket) return;
      this.retry_ms = FIRST_RETRY_MS;
      this.take(JSON.parse(String(frame.data)) as Message);
      if (this.connection !== "refused") this.listen();
    };
    socket.onclose = () => {
      if (socket === this.socket) this.lose();
    };
  }

  /** The server knows no such token: nothing is tried until there is another. */
  refuse(why: string): void {
    this.connection = "refused";
    this.refusal = why;
    this.tell();
  }

  /** Seconds since the server was last heard, by this device's steady clock. */
  silent_for_s(): number {
    return (performance.now() - this.heard_ms) / 1000;
  }

  private listen(): void {
    this.heard_ms = performance.now();
    clearTimeout(this.timer);
    const patience_s = this.trial?.running === true ? PATIENCE_RUNNING_S : PATIENCE * this.heartbeat_s;
    this.timer = window.setTimeout(() => this.lose(), patience_s * 1000);
  }

  private lose(): void {
    const socket = this.socket;
    this.socket = null;
    socket?.close();
    clearTimeout(this.timer);
    if (this.connection === "refused") return;
    this.connection = "lost";
    const spread = 0.75 + 0.5 * Math.random();
    this.timer = window.setTimeout(() => this.open(), this.retry_ms * spread);
    this.retry_ms = Math.min(2 * this.retry_ms, LAST_RETRY_MS);
    this.tell();
  }

  private take(message: Message): void {
    this.sequence = message.sequence;
    if (message.type !== "goodbye") {
      this.connection = "open";
      this.refusal = null;
    }
    switch (message.type) {
      case "snapshot":
        this.begin(message);
        break;
      case "trial_started":
        this.trial = message.trial;
        this.track_m = [];
        this.startRun();
        break;
      case "run_started":
        this.startRun();
        break;
      case "stage_started":
        if (this.trial?.progress)
          this.trial.progress = {
            ...this.trial.progress,
            stage: message.stage,
            elapsed_s: 0,
            remaining_s: message.at_most_s,
          };
        break;
      case "samples":
        for (const sample of message.samples) this.push(sample);
        if (this.trial !== null)
          Object.assign(this.trial, {
            progress: message.progress,
            estimate: message.estimate,
            envelope: message.envelope,
          });
        if (message.estimate && message.estimate.time_s !== this.estimates.at(-1)?.time_s)
          this.estimates.push(message.estimate);
        break;
      case "run_ended":
        if (this.trial !== null) {
          this.trial.runs = [...this.trial.runs.filter((run) => run.number !== message.run.number), message.run];
          this.trial.validation = message.validation ?? this.trial.validation ?? null;
        }
        break;
      case "trial_ended":
        if (this.trial !== null)
          Object.assign(this.trial, {
            running: false,
            outcome: message.outcome,
            verdict: message.verdict,
            runs: message.runs.length === 0 ? this.trial.runs : message.runs,
            warnings: message.warnings,
          });
        break;
      case "commission":
        this.commission = message.commission;
        break;
      case "control":
        this.learnControl(message.control);
        break;
      case "health":
        this.health = message.health;
        break;
      case "heartbeat":
      case "lagged":
        break;
      case "goodbye":
        if (message.code === "token_needed") this.refuse(message.message);
        break;
    }
    this.tell();
  }

  private begin(snapshot: Snapshot): void {
    this.stream = snapshot.stream;
    this.learnControl(snapshot.control);
    this.trial = snapshot.trial ?? null;
    this.commission = snapshot.commission ?? null;
    this.envelope = snapshot.envelope ?? null;
    this.health = snapshot.health ?? null;
    this.heartbeat_s = snapshot.settings.heartbeat_every_s;
    this.startRun();
    this.track_m = [];
    for (const sample of snapshot.samples) this.push(sample);
    this.track_m = snapshot.track_m.map(([north = 0, east = 0]) => [north, east]);
    this.estimates = snapshot.estimates;
  }

  /** The stream does not know who reads: whether control is ours is asked with our lease. */
  private learnControl(control: Control): void {
    this.control = control;
    if (secrets.lease === null || control.holder === null) return;
    status().then(
      (now) => {
        this.control = now.control;
        this.tell();
      },
      () => undefined,
    );
  }

  private startRun(): void {
    this.samples = noColumns();
    this.estimates = [];
    this.stages = [];
    this.lastHeading = null;
  }

  private push(sample: Sample): void {
    const { samples } = this;
    const heading = near(sample.heading_rad, this.lastHeading);
    this.lastHeading = heading ?? this.lastHeading;
    samples.time_s.push(sample.time_s);
    samples.heading_rad.push(heading);
    samples.simulated_heading_rad.push(near(sample.simulated_heading_rad, this.lastHeading));
    samples.yaw_rate_rad_s.push(sample.yaw_rate_rad_s ?? null);
    samples.rudder_rad.push(sample.rudder_rad ?? null);
    samples.surge_speed_m_s.push(sample.surge_speed_m_s ?? null);
    samples.depth_m.push(sample.depth_m ?? null);
    if (typeof sample.north_m === "number" && typeof sample.east_m === "number")
      this.track_m.push([sample.north_m, sample.east_m]);
    if (this.track_m.length > MOST_POINTS) this.track_m = this.track_m.filter((_, at) => at % 2 === 0);
    if (samples.time_s.length > MOST_POINTS) {
      for (const name of Object.keys(samples) as (keyof Columns)[])
        samples[name] = (samples[name] as never[]).filter((_, at) => at % 2 === 0);
    }
    const open = this.stages.at(-1);
    if (open !== undefined) open.to_s = sample.time_s;
    if (sample.stage && sample.stage !== open?.stage)
      this.stages.push({ stage: sample.stage, from_s: sample.time_s, to_s: sample.time_s });
  }

  private tell(): void {
    for (const callback of this.watchers) callback();
  }
}

/** Half the width of an interval as a fraction of the value. */
export function relativeHalfWidth(figure: Figure): number | null {
  const [low, high] = figure.interval_95 ?? [];
  return low === undefined || high === undefined || figure.value === 0
    ? null
    : (high - low) / 2 / Math.abs(figure.value);
}

/** The angle, turned by whole circles until it is nearest to another. */
function near(angle: number | null | undefined, to: number | null): number | null {
  if (angle === null || angle === undefined) return null;
  return to === null ? angle : angle - 2 * Math.PI * Math.round((angle - to) / (2 * Math.PI));
}

function noColumns(): Columns {
  return {
    time_s: [],
    heading_rad: [],
    simulated_heading_rad: [],
    yaw_rate_rad_s: [],
    rudder_rad: [],
    surge_speed_m_s: [],
    depth_m: [],
  };
}
