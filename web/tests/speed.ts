//! How long the page takes for a log, beside the terminal in the same rounds: `cargo xtask page --measure`.
//!
//! Of the page, the time from choosing the file to the verdict on the screen; of the terminal, that of `seatrial identify LOG --json`.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { readFileSync, readdirSync, statSync, writeFileSync } from "node:fs";
import { basename, dirname } from "node:path";
import { pathToFileURL } from "node:url";
import { gzipSync } from "node:zlib";
import { openBrowser, PATIENCE_MS } from "./server.ts";

const needed = (name: string): string => {
  const value = process.env[name];
  if (value === undefined) throw new Error(`${name} is not set: cargo xtask page --measure sets it`);
  return value;
};
const PAGE = needed("SEATRIAL_PAGE");
const BINARY = needed("SEATRIAL");
const LOG = needed("SEATRIAL_LOG");
/** One that is too long to be kept by the browser. */
const LONG_LOG = needed("SEATRIAL_LONG_LOG");
const TABLE = needed("SEATRIAL_TABLE");
const ROUNDS = Number(process.env["ROUNDS"] ?? 7);

/** What must hold. */
const MOST_RATIO = 3;
const MOST_MODULE_MB = 64;
/** Of the page's own thread, in which a person scrolls: 0.2 s where the terminal takes 0.4 s. */
const MOST_TASK_RATIO = 0.5;
const MOST_MS_TO_FIRST_PAINT = 1000;
const MOST_PACKED_MB = 3;

const megabytes = (log: string): string => (statSync(log).size / 1e6).toFixed(0);

interface Round {
  readonly ms: number;
  readonly longestTaskMs: number;
  readonly paintMs: number;
  readonly moduleBytes: number;
  readonly processBytes: number;
  readonly requests: number;
}

/** The most memory that any process of the browser's pages ever had. */
function mostMemory(): number {
  let most = 0;
  for (const pid of readdirSync("/proc").filter((name) => /^\d+$/.test(name))) {
    try {
      if (!readFileSync(`/proc/${pid}/cmdline`, "utf8").includes("--type=renderer")) continue;
      const kilobytes = /VmHWM:\s+(\d+)/.exec(readFileSync(`/proc/${pid}/status`, "utf8"))?.[1];
      most = Math.max(most, 1024 * Number(kilobytes ?? 0));
    } catch {
      // It has ended.
    }
  }
  return most;
}

/** A browser of its own each time: what it learned of the program is forgotten. */
async function round(): Promise<Round> {
  const browser = await openBrowser();
  try {
    const page = await browser.newPage();
    let requests = 0;
    await page.goto(pathToFileURL(PAGE).href);
    await page.getByText("Drop a log here").waitFor();
    page.on("request", (request) => (requests += /^(blob|data):/.test(request.url()) ? 0 : 1));
    // A person takes longer than this to choose a file.
    await page.waitForTimeout(1000);
    await page.evaluate((name) => {
      const seen = { begin: 0, end: 0, longest: 0 };
      Object.assign(window, { seen });
      new PerformanceObserver((list) => {
        for (const task of list.getEntries()) seen.longest = Math.max(seen.longest, task.duration);
      }).observe({ type: "longtask" });
      document
        .querySelector("input[type=file]")
        ?.addEventListener("change", () => (seen.begin = performance.now()), true);
      new MutationObserver(() => {
        if (seen.end === 0 && document.querySelector(".notice .loud")?.textContent?.startsWith(name))
          seen.end = performance.now();
      }).observe(document.body, { childList: true, subtree: true });
    }, basename(LOG));
    await page.locator("input[type=file]").setInputFiles(LOG);
    await page.getByText(`${basename(LOG)}: ✓`, { exact: false }).waitFor({ timeout: 10 * PATIENCE_MS });
    await page.getByRole("region", { name: "Channels" }).waitFor({ timeout: 10 * PATIENCE_MS });
    const found = await page.evaluate(() => {
      const { seen, seatrial } = window as unknown as {
        seen: { begin: number; end: number; longest: number };
        seatrial: { memory: number };
      };
      const paint = performance.getEntriesByName("first-contentful-paint")[0]?.startTime ?? Infinity;
      return { ms: seen.end - seen.begin, longestTaskMs: seen.longest, paintMs: paint, moduleBytes: seatrial.memory };
    });
    return { ...found, processBytes: mostMemory(), requests };
  } finally {
    await browser.close();
  }
}

/** Milliseconds that the terminal takes. */
function native(): number {
  const begin = performance.now();
  const done = spawnSync(BINARY, ["identify", LOG, "--json"], { maxBuffer: 1 << 28 });
  if (done.status !== 0) throw new Error(`seatrial identify ended with ${done.status}: ${done.stderr.toString()}`);
  return performance.now() - begin;
}

interface Long {
  readonly moduleBytes: number;
  readonly processBytes: number;
}

/** A log that is read in pieces: the document must be the terminal's; what memory it took. */
async function long(): Promise<Long> {
  const printed = spawnSync(BINARY, ["identify", basename(LONG_LOG), "--json"], {
    cwd: dirname(LONG_LOG),
    maxBuffer: 1 << 28,
    encoding: "utf8",
  });
  const browser = await openBrowser();
  try {
    const page = await browser.newPage();
    page.setDefaultTimeout(30 * PATIENCE_MS);
    await page.goto(pathToFileURL(PAGE).href);
    // An input beside the page's own, which would begin at once.
    await page.evaluate(() =>
      document.body.append(Object.assign(document.createElement("input"), { type: "file", id: "long" })),
    );
    await page.locator("#long").setInputFiles(LONG_LOG);
    const found = await page.evaluate(async () => {
      const { seatrial } = window as unknown as {
        seatrial: {
          memory: number;
          hold(file: File): Promise<void>;
          ask(request: object): Promise<{ document: unknown }>;
        };
      };
      const file = document.querySelector<HTMLInputElement>("#long")?.files?.[0];
      if (file === undefined) throw new Error("no file");
      await seatrial.hold(file);
      const { document: made } = await seatrial.ask({ ask: "identify", log: file.name });
      return { made, moduleBytes: seatrial.memory };
    });
    assert.deepEqual(found.made, JSON.parse(printed.stdout), "the document of a log that is read in pieces");
    return { moduleBytes: found.moduleBytes, processBytes: mostMemory() };
  } finally {
    await browser.close();
  }
}

const rounds: Round[] = [];
const terminal: number[] = [];
for (let k = 0; k < ROUNDS; k += 1) {
  terminal.push(native());
  rounds.push(await round());
}
const ofLong = await long();
const least = (values: readonly number[]): number => Math.min(...values);
const most = (values: readonly number[]): number => Math.max(...values);
const middle = (values: readonly number[]): number => [...values].sort((a, b) => a - b)[values.length >> 1] ?? NaN;
const pageMs = rounds.map(({ ms }) => ms);
const packed = gzipSync(readFileSync(PAGE), { level: 9 }).length / 1e6;
const moduleMb = most(rounds.map(({ moduleBytes }) => moduleBytes)) / 1e6;
const processMb = most(rounds.map(({ processBytes }) => processBytes)) / 1e6;
const goals: readonly [what: string, found: number, goal: number, digits: number][] = [
  ["time of the page over that of the terminal, least of each", least(pageMs) / least(terminal), MOST_RATIO, 2],
  ["memory of the module, MB", moduleMb, MOST_MODULE_MB, 1],
  [`the same for a log of ${megabytes(LONG_LOG)} MB`, ofLong.moduleBytes / 1e6, MOST_MODULE_MB, 1],
  [
    "longest task of the page's own thread over the time of the terminal, least of each",
    least(rounds.map(({ longestTaskMs }) => longestTaskMs)) / least(terminal),
    MOST_TASK_RATIO,
    2,
  ],
  ["first paint, ms", least(rounds.map(({ paintMs }) => paintMs)), MOST_MS_TO_FIRST_PAINT, 0],
  ["the page packed by gzip, MB", packed, MOST_PACKED_MB, 2],
  ["requests after it is loaded", most(rounds.map(({ requests }) => requests)), 0, 0],
];
const lines = [
  `A log of ${megabytes(LOG)} MB, ${ROUNDS} rounds by turns, each in a browser of its own.`,
  "",
  "| | least, ms | middle, ms |",
  "|---|---|---|",
  `| page, from the choice of the file to the verdict | ${least(pageMs).toFixed(0)} | ${middle(pageMs).toFixed(0)} |`,
  `| terminal, \`seatrial identify LOG --json\` | ${least(terminal).toFixed(0)} | ${middle(terminal).toFixed(0)} |`,
  "",
  "| | found | goal, at most | |",
  "|---|---|---|---|",
  ...goals.map(([what, found, goal, digits]) => {
    return `| ${what} | ${found.toFixed(digits)} | ${goal} | ${found <= goal ? "met" : "missed"} |`;
  }),
  "",
  `The most memory that a process of the browser's page had: ${processMb.toFixed(0)} MB, for the log of ${megabytes(LONG_LOG)} MB ${(ofLong.processBytes / 1e6).toFixed(0)} MB. The document of the latter is the terminal's, bit for bit.`,
];
writeFileSync(TABLE, `${lines.join("\n")}\n`);
console.log(lines.join("\n"));
const missed = goals.filter(([, found, goal]) => found > goal).map(([what]) => what);
if (missed.length > 0) {
  console.error(`missed: ${missed.join("; ")}`);
  process.exitCode = 1;
}
