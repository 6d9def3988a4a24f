//! A real server with a simulator behind it, and a browser before it.

import { type ChildProcess, spawn, spawnSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { type Browser, chromium } from "playwright-core";

const TARGET = process.env["CARGO_TARGET_DIR"] ?? "../target";
const BINARY = process.env["SEATRIAL"] ?? `${TARGET}/release/seatrial`;

export const scratch = mkdtempSync(join(tmpdir(), "seatrial-page-"));

/** Enough for the slowest step on two busy cores. */
export const PATIENCE_MS = 20_000;

export interface Trial {
  readonly running: boolean;
  readonly outcome: { readonly finished: boolean; readonly reason: string | null } | null;
  readonly progress: { readonly stage: string | null; readonly elapsed_s: number } | null;
  readonly runs: readonly { readonly accepted: boolean }[];
}

export interface Server {
  readonly url: string;
  /** All that it printed until it served. */
  readonly said: string;
  /** The trial that runs, or the last one. */
  trial(): Promise<Trial>;
  stop(): Promise<void>;
}

export async function until(what: string, is: () => Promise<boolean>): Promise<void> {
  const end = Date.now() + PATIENCE_MS;
  while (!(await is())) {
    if (Date.now() > end) throw new Error(`waited too long until ${what}`);
    await new Promise((resolve) => setTimeout(resolve, 25));
  }
}

/** Starts `seatrial serve` and waits until it says where. */
export async function serve(logbook: string, ...options: string[]): Promise<Server> {
  const serving = spawn(BINARY, ["serve", "--logbook", join(scratch, logbook), ...options], {
    stdio: ["ignore", "pipe", "pipe"],
  });
  let said = "";
  const url = await new Promise<string>((found, failed) => {
    const hear = (chunk: Buffer): void => {
      said += chunk.toString();
      const address = /http:\/\/[\d.]+:\d+\//.exec(said)?.[0];
      if (address !== undefined) found(address);
    };
    serving.stdout.on("data", hear);
    serving.stderr.on("data", hear);
    serving.on("exit", (code) => failed(new Error(`seatrial serve ended with ${code}: ${said}`)));
  });
  return {
    url,
    get said() {
      return said;
    },
    trial: async () => {
      const answer = await fetch(`${url}api/v1/status`);
      return ((await answer.json()) as { trial: Trial }).trial;
    },
    stop: () => ended(serving),
  };
}

/** Runs another verb to its end. */
export function seatrial(...options: string[]): void {
  const done = spawnSync(BINARY, options, { encoding: "utf8" });
  if (done.status !== 0) throw new Error(`seatrial ${options.join(" ")} ended with ${done.status}: ${done.stderr}`);
}

export function openBrowser(...more: string[]): Promise<Browser> {
  const args = [
    ...more,
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-dev-shm-usage",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
  ];
  return chromium.launch({ executablePath: process.env["CHROMIUM"] ?? "/usr/bin/chromium", args });
}

export function forget(): void {
  rmSync(scratch, { recursive: true, force: true });
}

function ended(serving: ChildProcess): Promise<void> {
  return new Promise((done) => {
    if (serving.exitCode !== null) done();
    serving.removeAllListeners("exit");
    serving.on("exit", () => done());
    serving.kill("SIGINT");
    setTimeout(() => serving.kill("SIGKILL"), 5000).unref();
  });
}
