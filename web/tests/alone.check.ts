//! The page that stands alone, opened from a file: its answers are those of the terminal, bit for bit, and it asks a network for nothing.

import assert from "node:assert/strict";
import { execFile, spawnSync } from "node:child_process";
import { readdirSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { join, relative } from "node:path";
import { DatabaseSync } from "node:sqlite";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import type { Browser, Page } from "playwright-core";
import { forget, openBrowser, PATIENCE_MS, scratch, seatrial } from "./server.ts";

const TARGET = process.env["CARGO_TARGET_DIR"] ?? "../target";
const PAGE = process.env["SEATRIAL_PAGE"] ?? `${TARGET}/alone/seatrial.html`;
const BINARY = process.env["SEATRIAL"] ?? `${TARGET}/debug/seatrial`;
const DATA = process.env["SEATRIAL_DATA"] ?? "../../shared/data";
const MOST_MS_TO_FIRST_PAINT = 1000;
const PYTHON = process.env["SEATRIAL_PYTHON"] ?? `${TARGET}/python/bin/python`;
/** Longest log that is compared: longer ones take a second each, twice. */
const MOST_BYTES = 2_100_000;

let browser: Browser;
let page: Page;
const requests: string[] = [];
const faults: string[] = [];

before(async () => {
  seatrial("sim", "log", "--seed", "1", "--thrust", "0.8", "--out", join(scratch, "own.csv"));
  browser = await openBrowser();
  const context = await browser.newContext({ acceptDownloads: true });
  context.setDefaultTimeout(PATIENCE_MS);
  page = await context.newPage();
  page.on("request", (request) => requests.push(request.url()));
  page.on("console", (message) => message.type() === "error" && faults.push(message.text()));
  page.on("pageerror", (error) => faults.push(error.message));
  await page.goto(pathToFileURL(PAGE).href);
  await page.getByText("Drop a log here").waitFor();
  requests.length = 0;
  await context.setOffline(true);
});

after(async () => {
  await browser?.close();
  forget();
});

type Answer = { readonly done: unknown } | { readonly refused: string };

/** Asks the page's own program; logs go in by their bytes. */
function ask(files: readonly (readonly [name: string, path: string])[], request: object): Promise<Answer> {
  const held = files.map(([name, path]) => [name, readFileSync(path).toString("base64")] as const);
  return page.evaluate(
    async ([files, request]) => {
      const { seatrial } = window as unknown as {
        seatrial: { hold(file: File): Promise<void>; ask(request: object): Promise<unknown> };
      };
      for (const [name, base64] of files) {
        const bytes = Uint8Array.from(atob(base64), (char) => char.charCodeAt(0));
        await seatrial.hold(new File([bytes], name));
      }
      try {
        return { done: await seatrial.ask(request) };
      } catch (error) {
        return { refused: error instanceof Error ? error.message : String(error) };
      }
    },
    [held, request] as const,
  );
}

/** What the terminal prints of a log that lies in a folder. */
function terminal(
  folder: string,
  ...words: string[]
): { readonly code: number; readonly out: string; readonly said: string } {
  const done = spawnSync(BINARY, words, { cwd: folder, encoding: "utf8", maxBuffer: 1 << 28 });
  return { code: done.status ?? -1, out: done.stdout, said: done.stderr };
}

/** What the terminal prints of a log, while the page works on it, too; where it refuses the log, nothing, and why. */
function printedBy(folder: string, file: string): Promise<readonly [printed: string, refusal: string]> {
  return new Promise((done) =>
    execFile(BINARY, ["identify", file, "--json"], { cwd: folder, maxBuffer: 1 << 28 }, (_, out, said) =>
      done([out, said.trim().split("\n").at(-1)?.replace("seatrial: ", "") ?? ""]),
    ),
  );
}

/** A refusal up to what is to be done about it, which each place says with what it has. */
function cause(refusal: string): string {
  return refusal.split(/[;:,] (?:say|name|or|leave|give|if|correct) /)[0] ?? "";
}

function logs(): string[] {
  const every = readdirSync(DATA, { recursive: true, encoding: "utf8" }).filter((name) =>
    /\.(csv|BIN|tlog|ulg|raw|all|dbd|alog|nmea|log)$/.test(name),
  );
  const isFew = (name: string): boolean =>
    !/^(simulated|firmware)/.test(name) || /_70_.*n0p3|_70_s0_h0|_1\.csv/.test(name);
  return every
    .filter((name) => isFew(name) && statSync(join(DATA, name)).size < MOST_BYTES && !/marks/.test(name))
    .sort();
}

test("answers on every log are those of the terminal, bit for bit", async (context) => {
  let names: string[] = [];
  if (DATA.endsWith("none")) {
    context.skip("there are no data to be had");
    return;
  }
  try {
    names = logs();
  } catch {
    if (process.env["CI"] === "true") throw new Error(`${DATA} is missing`);
    context.skip(`${DATA} is missing`);
    return;
  }
  assert.ok(names.length >= 25, `${names.length} logs`);
  const formats = new Set<string>();
  let models = 0;
  for (const name of names) {
    const path = join(DATA, name);
    const folder = join(path, "..");
    const file = relative(folder, path);
    const lists = name.endsWith(".dbd") ? readdirSync(join(folder, "cac")) : [];
    const files = [...lists.map((list) => [`cac/${list}`, join(folder, "cac", list)] as const), [file, path] as const];
    const [[printed, refusal], answer] = await Promise.all([
      printedBy(folder, file),
      ask(files, { ask: "identify", log: file }),
    ]);
    if (printed === "") {
      assert.ok("refused" in answer, `${name}: ${JSON.stringify(answer).slice(0, 300)}`);
      assert.equal(cause(answer.refused), cause(refusal), name);
      continue;
    }
    assert.ok("done" in answer, `${name}: ${JSON.stringify(answer).slice(0, 300)}`);
    const { document } = answer.done as { document: { source: { format: string }; refined: unknown } };
    assert.deepEqual(document, JSON.parse(printed), name);
    formats.add(document.source.format);
    models += document.refined === null ? 0 : 1;
    if (!/^native/.test(name)) continue;
    const inspected = await ask([], { ask: "inspect", log: file });
    assert.ok("done" in inspected);
    const { document: inspection } = inspected.done as { document: unknown };
    assert.deepEqual(inspection, JSON.parse(terminal(folder, "inspect", file, "--json").out), name);
  }
  context.diagnostic(`${names.length} logs, ${models} models, formats: ${[...formats].sort().join(", ")}`);
  assert.ok(models >= 20, `${models} models`);
  assert.ok(formats.size >= 6, [...formats].join(", "));
});

test("a recording in MCAP is read as in the terminal", async () => {
  seatrial("sim", "log", "--seed", "3", "--thrust", "0.8", "--out", join(scratch, "own.mcap"));
  const answer = await ask([["own.mcap", join(scratch, "own.mcap")]], { ask: "identify", log: "own.mcap" });
  assert.ok("done" in answer, JSON.stringify(answer).slice(0, 300));
  const { document } = answer.done as { document: { source: { format: string } } };
  assert.equal(document.source.format, "mcap");
  assert.deepEqual(document, JSON.parse(terminal(scratch, "identify", "own.mcap", "--json").out));
});

test("Parquet and packed MCAP are read as in the terminal", async (context) => {
  seatrial("sim", "log", "--seed", "3", "--thrust", "0.8", "--out", join(scratch, "packed.parquet"));
  seatrial("sim", "log", "--seed", "3", "--thrust", "0.8", "--out", join(scratch, "packed.mcap"));
  const logs: [file: string, format: string][] = [
    ["packed.parquet", "parquet"],
    ["packed.mcap", "mcap"],
  ];
  if (repack(join(scratch, "packed.mcap"), join(scratch, "lz4.mcap"))) logs.push(["lz4.mcap", "mcap"]);
  else if (process.env["CI"] === "true") throw new Error("the library mcap for Python is missing");
  else context.diagnostic("MCAP packed by lz4 is skipped: the library mcap for Python is missing");
  for (const [file, format] of logs) {
    const answer = await ask([[file, join(scratch, file)]], { ask: "identify", log: file });
    assert.ok("done" in answer, `${file}: ${JSON.stringify(answer).slice(0, 300)}`);
    const { document } = answer.done as { document: { source: { format: string }; refined: unknown } };
    assert.equal(document.source.format, format);
    assert.notEqual(document.refined, null, file);
    assert.deepEqual(document, JSON.parse(terminal(scratch, "identify", file, "--json").out), file);
  }
});

test("rosbag2 is refused, and what reads it is named", async () => {
  const bag = join(scratch, "boat.db3");
  new DatabaseSync(bag).exec("CREATE TABLE topics(id INTEGER PRIMARY KEY)");
  const answer = await ask([["boat.db3", bag]], { ask: "identify", log: "boat.db3" });
  assert.match(
    JSON.stringify(answer),
    /is rosbag2, which this page does not read; `seatrial identify` in a terminal does/,
  );
});

/** The messages of an MCAP file again, in chunks packed by lz4 in C. */
function repack(from: string, to: string): boolean {
  const program = `
import sys
from mcap.reader import make_reader
from mcap.writer import Writer, CompressionType
with open(sys.argv[1], "rb") as source, open(sys.argv[2], "wb") as target:
    writer = Writer(target, chunk_size=20000, compression=CompressionType.LZ4)
    writer.start()
    channels = {}
    for schema, channel, message in make_reader(source).iter_messages():
        if channel.id not in channels:
            known = writer.register_schema(schema.name, schema.encoding, schema.data)
            channels[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, known)
        writer.add_message(channels[channel.id], message.log_time, message.data, message.publish_time)
    writer.finish()
`;
  return spawnSync(PYTHON, ["-c", program, from, to]).status === 0;
}

test("report, gains, limits and parameters are those of the terminal", async () => {
  const path = join(scratch, "own.csv");
  const answer = await ask([["own.csv", path]], { ask: "identify", log: "own.csv" });
  assert.ok("done" in answer, JSON.stringify(answer));
  const { document } = answer.done as { document: unknown };
  assert.deepEqual(document, JSON.parse(terminal(scratch, "identify", "own.csv", "--json").out));

  terminal(scratch, "report", "own.csv", "--out", "own.html");
  const report = await ask([], { ask: "report", log: "own.csv" });
  assert.ok("done" in report);
  assert.equal((report.done as { html: string }).html, readFileSync(join(scratch, "own.html"), "utf8"));

  const model = terminal(scratch, "identify", "own.csv", "--json").out;
  writeFileSync(join(scratch, "model.json"), model);
  const gains = await ask([], { ask: "gains", origin: "model.json", document });
  assert.ok("done" in gains, JSON.stringify(gains));
  const { gains: found, turning } = gains.done as { gains: unknown; turning: unknown };
  assert.deepEqual(found, JSON.parse(terminal(scratch, "gains", "--model", "model.json", "--json").out));
  assert.deepEqual(turning, JSON.parse(terminal(scratch, "turn", "--model", "model.json", "--json").out));
  for (const [form, ...words] of [
    ["ardupilot_surface", "ardupilot"],
    ["px4_underwater", "px4", "--vehicle-type", "underwater"],
    ["ros2", "ros2"],
    ["c", "c"],
  ] as const) {
    const file = await ask([], { ask: "file", origin: "model.json", document, form });
    assert.ok("done" in file, JSON.stringify(file));
    const printed = terminal(scratch, "gains", "--model", "model.json", "--export", ...words);
    assert.equal((file.done as { text: string }).text, printed.out, form);
  }
});

test("a person drops a log, sees the verdict and takes the report", async () => {
  await page.locator("input[type=file]").setInputFiles(join(scratch, "own.csv"));
  await page.getByRole("region", { name: "Channels" }).waitFor();
  await page.getByRole("button", { name: "Identify", exact: true }).click();
  await page.getByText("own.csv: ✓ use", { exact: false }).waitFor();
  await page.getByText("Gains and limits").first().waitFor();
  const [download] = await Promise.all([
    page.waitForEvent("download"),
    page.getByRole("button", { name: "Report, HTML" }).click(),
  ]);
  assert.equal(download.suggestedFilename(), "own.html");
});

test("the page goes on while its program works", async () => {
  seatrial("sim", "log", "--seed", "2", "--out", join(scratch, "long.csv"));
  await ask([["long.csv", join(scratch, "long.csv")]], { ask: "columns", log: "long.csv" });
  const [turns, elapsed] = await page.evaluate(async () => {
    const { seatrial } = window as unknown as { seatrial: { ask(request: object): Promise<unknown> } };
    let [count, is] = [0, true];
    const begin = performance.now();
    const tick = (): void => {
      count += 1;
      if (is) setTimeout(tick, 5);
    };
    tick();
    await seatrial.ask({ ask: "identify", log: "long.csv" });
    is = false;
    return [count, performance.now() - begin] as const;
  });
  // A page that stands still turns once; one that goes on about every 5 ms.
  assert.ok(turns > 3 && turns > elapsed / 20, `${turns} turns of the page's loop in ${elapsed} ms`);
});

test("a simulated trial is judged against its truth", async () => {
  await page.getByRole("link", { name: "A simulated trial" }).click();
  await page.getByRole("button", { name: "Run the trial" }).click();
  await page.getByText("holds the truth").first().waitFor();
  await page.locator("input[name=compass_noise_rad]").fill("3");
  await page.locator("input[name=rudder_rad]").fill("2");
  await page.getByRole("button", { name: "Run the trial" }).click();
  await page.getByText(/simulated.csv: . (do not use|use with care)/).waitFor();
});

test("a log that is none is refused in words", async () => {
  writeFileSync(join(scratch, "not.csv"), "this is no log\n");
  const refused = await ask([["not.csv", join(scratch, "not.csv")]], { ask: "identify", log: "not.csv" });
  assert.ok("refused" in refused && refused.refused.startsWith("not.csv: "), JSON.stringify(refused));
});

test("it is seen at once, and nothing was asked of a network", async () => {
  const own = await (await browser.newContext()).newPage();
  await own.goto(pathToFileURL(PAGE).href);
  await own.getByText("Drop a log here").waitFor();
  const paint = await own.evaluate(
    () =>
      new Promise<number>((seen) => {
        new PerformanceObserver((list) => {
          list.getEntriesByName("first-contentful-paint").forEach((entry) => seen(entry.startTime));
        }).observe({ type: "paint", buffered: true });
      }),
  );
  await own.context().close();
  assert.ok(paint < MOST_MS_TO_FIRST_PAINT, `${paint} ms`);
  assert.deepEqual(
    requests.filter((url) => !url.startsWith("blob:") && !url.startsWith("data:")),
    [],
  );
  assert.deepEqual(faults, []);
});
