//! A real server with a simulator behind it, and a browser before it.

import { type ChildProcess, spawn, spawnSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { type Browser, chromium } from "playwright-core";

const BINARY = process.env["SEATRIAL"] ?? "../target/release/seatrial";

export const scratch = mkdtempSync(join(tmpdir(), "seatrial-page-"));

export interface Server {
  readonly url: string;
  /** All that it printed until it served. */
  readonly said: string;
  stop(): Promise<void>;
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
    stop: () => ended(serving),
  };
}

/** Runs another verb to its end. */
export function seatrial(...options: string[]): void {
  const done = spawnSync(BINARY, options, { encoding: "utf8" });
  if (done.status !== 0) throw new Error(`seatrial ${options.join(" ")} ended with ${done.status}: ${done.stderr}`);
}

export function openBrowser(): Promise<Browser> {
  const args = [
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
