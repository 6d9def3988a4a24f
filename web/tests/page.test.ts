//! The page in a browser, over a real server that conducts real trials on the simulator.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import type { Browser, BrowserContext, Page } from "playwright-core";
import { violations } from "./axe.ts";
import { forget, openBrowser, PATIENCE_MS, scratch, seatrial, serve, type Server, until } from "./server.ts";

const VIEWS = [
  "#/live",
  "#/control",
  "#/commission",
  "#/history",
  "#/history/campaign/1",
  "#/history/compare/2/3",
  "#/history/log",
];
const THEMES = ["light", "dark", "sunlight"];

let server: Server;
let browser: Browser;
let context: BrowserContext;
let page: Page;
const faults: string[] = [];

before(async () => {
  server = await serve("page.db", "--listen", "127.0.0.1:0");
  browser = await openBrowser();
  context = await browser.newContext({ viewport: { width: 1440, height: 1000 } });
  context.setDefaultTimeout(PATIENCE_MS);
  page = await context.newPage();
  page.on("console", (message) => message.type() === "error" && faults.push(message.text()));
  page.on("pageerror", (error) => faults.push(error.message));
});

after(async () => {
  await browser?.close();
  await server?.stop();
  forget();
});

async function visit(hash: string, on: Page = page): Promise<void> {
  await on.goto(`${server.url}${hash}`);
}

async function start(thrusts: string, configuration: string, pace: string): Promise<void> {
  await visit("#/control");
  await page.getByLabel("Speeds, thrust").fill(thrusts);
  await page.getByLabel("Configuration").fill(configuration);
  await page.getByLabel("Pace").selectOption(pace);
  await page.getByRole("button", { name: /^Check/ }).click();
  await page.getByText("✓ ready").waitFor();
  await page.getByRole("button", { name: "Start the trial" }).click();
  await page.waitForURL(/#\/live$/);
}

/** Identifies the log whose preview is shown. */
async function identify(): Promise<void> {
  await page.getByRole("region", { name: "Channels" }).waitFor();
  await page.getByRole("button", { name: "Identify", exact: true }).click();
}

/** Milliseconds until something of the live view can be seen, and bytes of the page, opened by who has never seen it. */
async function firstSight(selector: string): Promise<[number, number]> {
  const own = await (await browser.newContext()).newPage();
  await own.addInitScript((wanted) => {
    const look = (): void => {
      const found = document.querySelector<HTMLElement>(wanted);
      if (found === null || found.offsetHeight === 0) requestAnimationFrame(look);
      else document.documentElement.setAttribute("data-seen", String(performance.now()));
    };
    look();
  }, selector);
  const sizes: Promise<number>[] = [];
  own.on("requestfinished", (request) => {
    if (!request.url().includes("/api/")) sizes.push(request.sizes().then((size) => size.responseBodySize));
  });
  await visit("#/live", own);
  await own.locator("[data-seen]").waitFor();
  const seen = Number(await own.locator("html").getAttribute("data-seen"));
  await own.waitForLoadState("networkidle");
  own.removeAllListeners("requestfinished");
  const bytes = (await Promise.all(sizes)).reduce((sum, size) => sum + size, 0);
  await own.context().close();
  return [seen, bytes];
}

async function isSeenAtOnce(what: string, selector: string): Promise<void> {
  // The first of several sights that is quick enough: the machine may be busy with something else.
  let [seen, bytes] = await firstSight(selector);
  for (let again = 0; again < 4 && seen >= 1000; again += 1) [seen, bytes] = await firstSight(selector);
  console.log(`${what} after ${seen.toFixed(0)} ms, page of ${(bytes / 1000).toFixed(1)} kB compressed`);
  assert.ok(seen < 1000);
  assert.ok(bytes > 10_000 && bytes < 300_000);
}

test("three ways to begin within 1 s, page below 300 kB compressed", () =>
  isSeenAtOnce("the ways to begin", ".starts"));

test("take control, start, watch, abort in mid doublet by key, with a wrong clock", async () => {
  // The page may use no time but the server's and the vehicle's.
  await page.addInitScript(() => (Date.now = () => 0));
  await visit("#/control");
  await page.getByLabel("Your name").fill("Ada");
  await page.getByRole("button", { name: "Take control" }).click();
  await page.getByText("You have control, as Ada.").waitFor();
  await start("60, 80", "default", "real time × 10");
  await page.locator(".stages .train.now").waitFor();
  // Both deflections of the paper's doublet lie between 2 and 6 s.
  await until("the doublet", async () => ((await server.trial()).progress?.elapsed_s ?? 0) > 2.5);
  await page.keyboard.press(".");
  await page.locator(".loud", { hasText: "The trial ended early" }).waitFor();
  await page.getByText("The rudder is neutral and the vehicle is handed back.").waitFor();
  await page.getByRole("button", { name: "Go on at the next speed" }).waitFor();
  const ended = await server.trial();
  assert.equal(ended.outcome?.reason, "operator");
  assert.equal(ended.running, false);
});

test("where there was a trial, its first chart within 1 s", () => isSeenAtOnce("first chart", "canvas"));

test("two trials are validated, compared and looked at over speed", async () => {
  await start("60, 80", "bare", "as fast as it can");
  await page.locator(".loud", { hasText: "The trial is finished" }).waitFor();
  await page.getByRole("link", { name: "Gains, limits and files" }).waitFor();
  await page.locator("p", { hasText: /the model explains \d/ }).waitFor();
  assert.ok((await server.trial()).runs.every((run) => run.accepted));
  await start("60, 80", "sonar", "as fast as it can");
  await page.getByText("sim:starfish · sonar · ended").waitFor();

  await visit("#/history");
  await page.getByRole("button", { name: "Compare A with B" }).click();
  await page.getByRole("heading", { name: "60 % thrust" }).waitFor();
  assert.equal(await page.locator("tbody th", { hasText: "Kₚ" }).count(), 2);

  await visit("#/history/campaign/3");
  const slider = page.getByRole("slider");
  await page.locator("dt", { hasText: "phase margin" }).waitFor();
  const middle = await slider.getAttribute("aria-valuetext");
  await slider.press("End");
  await until("the slider is answered", async () => (await slider.getAttribute("aria-valuetext")) !== middle);
  const file = page.waitForEvent("download");
  await page.getByRole("button", { name: "Report, HTML" }).click();
  assert.equal((await file).suggestedFilename(), "campaign-3.html");
  await page.getByRole("region", { name: /^Turning with .* of rudder$/ }).waitFor();
  for (const [name, extension] of [
    ["ArduPilot Rover", "param"],
    ["PX4 rover", "params"],
    ["ROS 2", "yaml"],
    ["JSON", "json"],
    ["C header", "h"],
    ["Vehicle file, TOML", "toml"],
  ] as const) {
    const gains = page.waitForEvent("download");
    await page.getByRole("button", { name: new RegExp(`^${name}`) }).click();
    assert.equal((await gains).suggestedFilename(), `campaign-3.${extension}`);
  }
});

test("a run is rejected with a note and accepted again", async () => {
  await visit("#/history/campaign/3");
  for (const [verb, word] of [
    ["Reject", "rejected by Ada"],
    ["Accept", "accepted by Ada"],
  ] as const) {
    await page.getByRole("button", { name: "Review run 1" }).click();
    await page.locator("form canvas").first().waitFor();
    await page.getByLabel("Note").fill("a wave");
    await page.getByRole("button", { name: `${verb} this run` }).click();
    await page.getByRole("cell", { name: word }).waitFor();
  }
});

test("a log is dropped on the page and identified; what is no log is refused in words", async () => {
  const log = join(scratch, "run.csv");
  seatrial("sim", "log", "--seed", "3", "--out", log);
  await visit("#/history/log");
  const dropped = await page.evaluateHandle(
    (text) => {
      const transfer = new DataTransfer();
      transfer.items.add(new File([text], "run.csv"));
      return transfer;
    },
    readFileSync(log, "utf8"),
  );
  await page.locator(".drop").dispatchEvent("drop", { dataTransfer: dropped });
  await identify();
  await page.getByText(/^run.csv: (✓ use|! use with care)$/).waitFor();
  await page.locator("figure canvas").first().waitFor();
  const before = faults.length;
  await page
    .locator("input[type=file]")
    .setInputFiles({ name: "poem.csv", mimeType: "text/csv", buffer: Buffer.from("no,numbers\nare,here\n") });
  await page.getByRole("alert").getByText("poem.csv").waitFor();
  // The browser itself reports the refusal.
  faults.splice(before);
});

test("a log with names of its own is read as told", async () => {
  const log = join(scratch, "single.csv");
  seatrial("sim", "log", "--seed", "3", "--thrust", "0.8", "--out", log);
  const odd = readFileSync(log, "utf8").replace("heading_rad", "alpha").replace("yaw_rate_rad_s", "beta");
  await visit("#/history/log");
  const before = faults.length;
  await page
    .locator("input[type=file]")
    .setInputFiles({ name: "odd.csv", mimeType: "text/csv", buffer: Buffer.from(odd) });
  await page.getByRole("alert").getByText("no column for heading").waitFor();
  await page.getByLabel("Heading from column").selectOption("alpha");
  await page.getByLabel("Heading is in").selectOption("rad");
  await page.getByRole("button", { name: "Look at the log again" }).click();
  await identify();
  await page.getByText(/^odd.csv: (✓ use|! use with care)$/).waitFor();
  const remarks = page.locator(".notice details");
  await remarks.getByText(/^\d+ more remarks?$/).click();
  await remarks.locator("li").first().waitFor();
  assert.ok(!(await remarks.innerText()).includes("--"));
  faults.splice(before);
});

test("a log with a damaged row is refused by the name of a control, which reads it", async () => {
  const rows = readFileSync(join(scratch, "run.csv"), "utf8").split("\n");
  const damaged = [...rows.slice(0, 40), rows[40]?.replace(/[^,]+/, "noon"), ...rows.slice(41)].join("\n");
  await visit("#/history/log");
  await page.reload();
  const before = faults.length;
  await page
    .locator("input[type=file]")
    .setInputFiles({ name: "damaged.csv", mimeType: "text/csv", buffer: Buffer.from(damaged) });
  const told = page.getByRole("alert").getByText("line 41");
  await told.waitFor();
  const text = await told.innerText();
  assert.ok(text.includes("Leave out damaged rows") && !text.includes("--"), text);
  await page.getByLabel("Leave out damaged rows").check();
  await page.getByRole("button", { name: "Look at the log again" }).click();
  await identify();
  await page.getByText(/^damaged.csv: (✓ use|! use with care)$/).waitFor();
  faults.splice(before);
});

test("windows are dragged over the record, and its model is kept as a file", async () => {
  await visit("#/history/log");
  await page.reload();
  await page.locator("input[type=file]").setInputFiles(join(scratch, "run.csv"));
  await identify();
  const form = page.getByRole("form", { name: "Windows" });
  await form.waitFor();
  const [from, to, validateFrom] = [0, 1, 2].map((at) => form.locator("input[type=number]").nth(at));
  const found = await to?.inputValue();
  const over = page.locator(".u-over").first();
  await over.scrollIntoViewIfNeeded();
  const box = await over.boundingBox();
  assert.ok(box && from && to && validateFrom);
  await page.mouse.move(box.x + 0.1 * box.width, box.y + 20);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.4 * box.width, box.y + 20, { steps: 4 });
  await page.mouse.up();
  const dragged = await to.inputValue();
  assert.notEqual(dragged, found);
  assert.ok(Number(dragged) > Number(await from.inputValue()));
  await page.getByRole("button", { name: "Identify with these windows" }).click();
  await page
    .getByText(/^run.csv: /)
    .first()
    .waitFor();
  assert.equal(await form.locator("input[type=number]").nth(1).inputValue(), dragged);
  await page.getByRole("button", { name: "Find the manoeuvres" }).click();
  await page.getByText(/^run.csv: (✓ use|! use with care)$/).waitFor();
  const file = page.waitForEvent("download");
  await page.getByRole("button", { name: "Model, JSON" }).click();
  assert.equal((await file).suggestedFilename(), "run.model.json");
});

test("who comes first has three ways to go, each leads on", async () => {
  const fresh = await serve("first.db", "--listen", "127.0.0.1:0");
  const own = await (await browser.newContext()).newPage();
  try {
    await own.goto(fresh.url);
    assert.deepEqual(await own.locator(".start b").allInnerTexts(), ["Rehearse", "Trial", "Open a log"]);
    assert.equal(await own.locator("main figure:visible, main canvas:visible, .stages:visible").count(), 0);
    await own.getByRole("link", { name: /^Rehearse/ }).click();
    await own.getByRole("combobox", { name: /^Vehicle/ }).waitFor();
    await own.goto(fresh.url);
    await own.getByRole("link", { name: /^Trial/ }).click();
    await own.getByText("Start it with yours").waitFor();
    await own.goto(fresh.url);
    await own.getByRole("link", { name: /^Open a log/ }).click();
    await own.getByText("Drop a log here").waitFor();
  } finally {
    await own.context().close();
    await fresh.stop();
  }
});

test("who comes back without the lease waits for it with a countdown", async () => {
  const own = await (await browser.newContext()).newPage();
  await visit("#/control", own);
  await own.getByLabel("Your name").fill("Bo");
  await own.getByRole("button", { name: "Take over when it lapses" }).click();
  await own.getByText(/^Ada was last heard \d+ s ago. Control is yours in \d+ s/).waitFor();
  await own.context().close();
});

test("a campaign that ended early goes on at the speed that was broken off", async () => {
  await visit("#/history/campaign/1");
  await page.getByRole("button", { name: "Go on at the next speed" }).click();
  await page.waitForURL(/#\/live$/);
  await page.locator(".stages .now").waitFor();
  assert.deepEqual(await page.locator(".speeds b").allInnerTexts(), ["60\u00a0%", "80\u00a0%"]);
  await page.keyboard.press(".");
  await page.locator(".loud", { hasText: "The trial ended early" }).waitFor();
});

test("no violation of axe-core, nothing cut, no target below 48 px, in each view and theme", async () => {
  for (const [width, themes] of [
    [1440, THEMES],
    [360, ["light", "sunlight"]],
    [3840, ["dark"]],
  ] as const) {
    await page.setViewportSize({ width, height: Math.min(width, 1000) });
    for (const theme of themes) {
      await visit("#/live");
      await page.getByLabel("Theme").selectOption(theme);
      for (const view of VIEWS) {
        await visit(view);
        await page.waitForLoadState("networkidle");
        const where = `${view} ${theme} ${width}`;
        assert.deepEqual(await violations(page), [], where);
        const [needed, small] = await page.evaluate(() => [
          document.documentElement.scrollWidth,
          [
            ...document.querySelectorAll<HTMLElement>(
              "button, select, nav a, .touch, .file, input:not([type=radio], [type=checkbox], .unseen)",
            ),
          ]
            .filter((target) => target.offsetParent !== null && target.offsetHeight < 48)
            .map((target) => target.outerHTML),
        ]);
        assert.ok(Number(needed) <= width, `${where} needs ${needed} px`);
        assert.deepEqual(small, [], where);
      }
    }
  }
  await page.setViewportSize({ width: 1440, height: 1000 });
});

test("the keyboard alone reaches every view", async () => {
  await visit("#/live");
  // Opened anew: a view that is gone to takes the focus.
  await page.reload();
  await page.keyboard.press("Tab");
  assert.equal(await page.evaluate(() => document.activeElement?.textContent), "Skip to the view");
  for (const view of ["Live", "Control", "Gains", "History"]) {
    await page.keyboard.press("Tab");
    assert.equal(await page.evaluate(() => document.activeElement?.textContent), view);
  }
  await page.keyboard.press("Enter");
  await page.waitForURL(/#\/history$/);
});

test("a wrong token is refused, the right one is not", async () => {
  const guarded = await serve("guarded.db", "--listen", "127.0.0.1:0", "--require-token");
  try {
    const own = await (await browser.newContext()).newPage();
    await own.goto(guarded.url);
    await own.getByRole("heading", { name: "Token needed" }).waitFor();
    await own.getByLabel("Token").fill("guess");
    await own.getByRole("button", { name: "Enter" }).click();
    await own.getByText("The token was refused").waitFor();
    const [token] = /[0-9a-f]{64}/.exec(guarded.said) ?? [];
    assert.ok(token, guarded.said);
    await own.getByLabel("Token").fill(token);
    await own.getByRole("button", { name: "Enter" }).click();
    await own.locator(".loud", { hasText: "No trial is running" }).waitFor();
  } finally {
    await guarded.stop();
  }
});

test("no error in the console", () => assert.deepEqual(faults, []));

test("a lost connection is said and mended when the server is back", async () => {
  await visit("#/live");
  await page.getByText("sim:starfish · default · ended").waitFor();
  const { port } = new URL(server.url);
  await server.stop();
  await page.getByText("Connection lost").waitFor();
  server = await serve("page.db", "--listen", `127.0.0.1:${port}`);
  await page.getByText("Connection lost").waitFor({ state: "hidden" });
  await page.locator(".loud", { hasText: "No trial is running" }).waitFor();
});
