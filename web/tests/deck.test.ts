//! The page as it is used on deck: gloves, sunlight, two operators, a phone, a large screen.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import type { Browser, BrowserContextOptions, Page } from "playwright-core";
import { violations } from "./axe.ts";
import { forget, openBrowser, PATIENCE_MS, scratch, seatrial, serve, type Server, until } from "./server.ts";

/** Contrast that WCAG asks of text at level AAA. */
const CONTRAST_AAA = 7;
/** Longer than Esc must be held. */
const HELD_MS = 900;

let server: Server;
let browser: Browser;

before(async () => {
  server = await serve("deck.db", "--listen", "127.0.0.1:0");
  browser = await openBrowser();
});

after(async () => {
  await browser?.close();
  await server?.stop();
  forget();
});

async function opened(hash: string, options: BrowserContextOptions = {}): Promise<Page> {
  const context = await browser.newContext({ viewport: { width: 1440, height: 1000 }, ...options });
  context.setDefaultTimeout(PATIENCE_MS);
  const page = await context.newPage();
  await page.goto(`${server.url}${hash}`);
  return page;
}

async function takeControl(page: Page, name: string): Promise<void> {
  await page.getByLabel("Your name").fill(name);
  await page.getByRole("button", { name: "Take control" }).click();
}

const holder = (page: Page, text: string): Promise<void> => page.locator(".bar .badge", { hasText: text }).waitFor();

test("the second operator is told who has control, and has it when it is given back", async () => {
  const [ada, ben] = [await opened("#/control"), await opened("#/control")];
  await takeControl(ada, "Ada");
  await ada.getByText("You have control, as Ada.").waitFor();
  await holder(ben, "Ada has control");
  await ben.getByText("Ada has control.", { exact: true }).waitFor();
  assert.ok(await ben.getByRole("button", { name: "Start the trial" }).isDisabled());

  await ben.getByLabel("Your name").fill("Ben");
  await ben.getByRole("button", { name: "Take over when it lapses" }).click();
  await ben.getByText("Control is yours in").waitFor();
  await ada.getByRole("button", { name: "Give control back" }).click();
  await ben.getByText("You have control, as Ben.").waitFor();
  await holder(ada, "Ben has control");
  await ben.getByRole("button", { name: "Give control back" }).click();
  // A page that closes may not have said so yet.
  await ada.getByText("Nobody has control.").waitFor();
  await ada.context().close();
  await ben.context().close();
});

test("units are metric or nautical, and stay as chosen", async () => {
  const page = await opened("#/control");
  const speed = page.locator("table tbody tr").first().locator("td").nth(1);
  await speed.getByText("m/s").waitFor();
  const metric = parseFloat(await speed.innerText());
  await page.getByLabel("Units").selectOption("nautical");
  await speed.getByText("kn").waitFor();
  const ratio = parseFloat(await speed.innerText()) / metric;
  // Both are rounded to three digits.
  assert.ok(Math.abs(ratio - 3600 / 1852) < 0.01, `${ratio}`);
  await page.locator(".track", { hasText: "ft" }).waitFor();
  await page.reload();
  await speed.getByText("kn").waitFor();
  await page.context().close();
});

test("nothing moves by itself for who wants reduced motion", async () => {
  for (const [reducedMotion, seconds] of [
    ["reduce", "0s"],
    ["no-preference", "0.2s"],
  ] as const) {
    const page = await opened("#/live", { reducedMotion });
    const filled = page.locator(".stages .filled").first();
    await filled.waitFor({ state: "attached" });
    assert.equal(await filled.evaluate((bar) => getComputedStyle(bar).transitionDuration), seconds);
    await page.context().close();
  }
});

test("the sunlight theme has the contrast, weight and lines for it", async () => {
  const page = await opened("#/live");
  await page.getByLabel("Theme").selectOption("sunlight");
  await page.reload();
  const seen = await page.evaluate(() => {
    const style = getComputedStyle(document.documentElement);
    const luminance = (name: string): number => {
      const short = style.getPropertyValue(name).trim().slice(1);
      const digits = short.length === 3 ? [...short].map((digit) => digit + digit).join("") : short;
      const [red = 0, green = 0, blue = 0] = [0, 2, 4]
        .map((at) => parseInt(digits.slice(at, at + 2), 16) / 255)
        .map((part) => (part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4));
      return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    };
    const contrast = (a: string, b: string): number => {
      const [dark = 0, light = 0] = [luminance(a), luminance(b)].sort((x, y) => x - y);
      return (light + 0.05) / (dark + 0.05);
    };
    return {
      contrasts: ["--ink", "--soft", "--a", "--b", "--c", "--d", "--bad"].map((ink) => [ink, contrast(ink, "--paper")]),
      weight: getComputedStyle(document.body).fontWeight,
      line: Number(style.getPropertyValue("--weight")),
      size: parseFloat(style.fontSize),
    };
  });
  for (const [ink, contrast] of seen.contrasts) assert.ok(Number(contrast) >= CONTRAST_AAA, `${ink} ${contrast}`);
  assert.equal(seen.weight, "600");
  assert.ok(seen.line >= 3 && seen.size >= 18);
  await page.context().close();
});

/** Takes control and starts a trial of some minutes. */
async function underWay(): Promise<Page> {
  const page = await opened("#/control");
  await takeControl(page, "Ada");
  await page.getByLabel("Pace").selectOption("real time × 10");
  await page.getByRole("button", { name: /^Check/ }).click();
  await page.getByRole("button", { name: "Start the trial" }).click();
  await page.waitForURL(/#\/live$/);
  await page.locator(".stages .now").waitFor();
  return page;
}

/** Texts of a page that take no room on it, or hang out of what holds them. */
const unseen = (page: Page, selector: string): Promise<string[]> =>
  page.locator(selector).evaluateAll((all) =>
    all.flatMap((one) => {
      const range = document.createRange();
      range.selectNodeContents(one);
      const [text, box] = [range.getBoundingClientRect(), one.getBoundingClientRect()];
      const isWhole = text.left >= box.left - 1 && text.right <= box.right + 1 && text.width > 20;
      return isWhole ? [] : [`${one.textContent ?? ""}: ${text.width} in ${box.width}`];
    }),
  );

async function landed(page: Page): Promise<void> {
  await until("the trial has ended", async () => !(await server.trial()).running);
  await page.locator(".loud", { hasText: "The trial ended early" }).waitFor();
  assert.equal((await server.trial()).outcome?.reason, "operator");
  // A simulated vehicle needs nobody's agreement to move again.
  assert.ok(await page.getByRole("button", { name: "Go on at the next speed" }).isEnabled());
  assert.equal(await page.getByText("moves again").count(), 0);
  // Chips keep their word on a phone.
  await page.setViewportSize({ width: 390, height: 844 });
  const chips = await page.locator(".speeds small").allInnerTexts();
  assert.ok(chips.includes("not run") && chips[0]?.includes("use"), chips.join());
  assert.deepEqual(await unseen(page, ".speeds small"), []);
  await page.goto(`${server.url}#/control`);
  await page.getByRole("button", { name: "Give control back" }).click();
  await page.getByText("Nobody has control.").waitFor();
  await page.context().close();
}

test("Esc aborts when it is held, and only then", async () => {
  const page = await underWay();
  await page.keyboard.press("Escape");
  await page.waitForTimeout(HELD_MS);
  assert.ok((await server.trial()).running);
  await page.keyboard.down("Escape");
  await page.waitForTimeout(HELD_MS);
  await page.keyboard.up("Escape");
  await landed(page);
});

test("a phone has the red button under the thumb; a touch aborts, also by a thumb that slips off", async () => {
  const pilot = await underWay();
  const phone = await opened("#/live", { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
  // From the training on there are estimates to draw.
  await phone.locator(".stages .train.now").waitFor();
  await phone.locator("canvas").nth(7).waitFor();
  const abort = phone.getByRole("button", { name: /ABORT/ });
  for (const at of [0, 1e6]) {
    await phone.evaluate((y) => scrollTo(0, y), at);
    const box = await abort.boundingBox();
    assert.ok(box !== null && box.height >= 64 && box.width >= 300, JSON.stringify(box));
    assert.ok(box.y > 844 / 2 && box.y + box.height <= 844, JSON.stringify(box));
  }
  // At one instant: a live panel grows when its first figures come, and the page with it.
  const [lowest, button] = await phone.evaluate(() => {
    scrollTo(0, 1e6);
    const panels = [...document.querySelectorAll("main .panel")].map((panel) => panel.getBoundingClientRect().bottom);
    return [Math.max(...panels), document.querySelector(".abort")?.getBoundingClientRect().toJSON() as DOMRect];
  });
  assert.ok(lowest <= button.y, `something is under the button: ${lowest} of ${button.y} px`);
  assert.ok((await phone.evaluate(() => document.documentElement.scrollWidth)) <= 390);
  const touch = await phone.context().newCDPSession(phone);
  const thumb = { x: button.x + button.width / 2, y: button.y + button.height / 2 };
  const away = { x: thumb.x, y: 100 };
  const arrived = phone.waitForResponse(/trial\/abort$/);
  await touch.send("Input.dispatchTouchEvent", { type: "touchStart", touchPoints: [thumb] });
  await touch.send("Input.dispatchTouchEvent", { type: "touchMove", touchPoints: [away] });
  await touch.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
  assert.equal((await arrived).status(), 202);
  await phone.context().close();
  await landed(pilot);
});

test("4K: everything live on one screen, in letters that can be read from afar", async () => {
  const page = await opened("#/live", { viewport: { width: 3840, height: 2160 } });
  // Of a trial that is over the page shows most.
  await page.getByRole("heading", { name: "What comes next" }).waitFor();
  await page.locator("canvas").nth(7).waitFor();
  const [height, size] = await page.evaluate(() => [
    document.documentElement.scrollHeight,
    parseFloat(getComputedStyle(document.documentElement).fontSize),
  ]);
  assert.ok(Number(height) <= 2160, `${height} px high`);
  assert.ok(Number(size) >= 20, `${size} px`);
  await page.context().close();
});

/** Presses a button that writes a file; its name and its text. */
async function written(page: Page, button: string): Promise<[string, string]> {
  const [download] = await Promise.all([
    page.waitForEvent("download"),
    page.getByRole("button", { name: button, exact: true }).click(),
  ]);
  return [download.suggestedFilename(), readFileSync(await download.path(), "utf8")];
}

test("a log ends in gains, limits, parameters, vehicle file and report, as in the terminal", async () => {
  const place = (name: string): string => join(scratch, name);
  seatrial("sim", "log", "--seed", "1", "--out", place("run.csv"));
  for (const viewport of [
    { width: 1440, height: 1000 },
    { width: 390, height: 844 },
  ]) {
    const page = await opened("#/history/log", { viewport });
    await page.locator("input[type=file]").setInputFiles(place("run.csv"));
    await page.getByRole("region", { name: "First rows as read" }).waitFor();
    await page.getByRole("button", { name: "Identify", exact: true }).click();
    await page.getByText(/^run.csv: ✓ use$/).waitFor();
    await page.getByRole("region", { name: "Gains", exact: true }).waitFor();
    await page.getByRole("region", { name: /^Turning with .* of rudder$/ }).waitFor();

    const [model, json] = await written(page, "Model, JSON");
    assert.equal(model, "run.model.json");
    writeFileSync(place("run.csv.json"), json);
    for (const [button, name, ...words] of [
      ["ArduPilot Rover, .param", "run.param", "gains", "--export", "ardupilot"],
      ["PX4 rover, .params", "run.params", "gains", "--export", "px4"],
      ["Vehicle file, TOML", "run.toml", "export", "--to", "vehicle"],
    ] as const) {
      const [file, text] = await written(page, button);
      assert.equal(file, name);
      const out = place(`terminal-${name}`);
      seatrial(...words, "--model", place("run.csv.json"), "--out", out);
      const own = text.replaceAll("run.csv", "");
      assert.equal(own, readFileSync(out, "utf8").replaceAll(place("run.csv.json"), ""), name);
    }
    const [report, html] = await written(page, "Report, HTML");
    assert.equal(report, "run.html");
    assert.ok(html.trimStart().startsWith("<!DOCTYPE html>"));
    assert.deepEqual(await violations(page), []);
    assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= viewport.width);
    await page.context().close();
  }
});

test("of a log whose speed varies the mean is taken, and said", async () => {
  seatrial("sim", "log", "--seed", "1", "--thrust", "0.8", "--out", join(scratch, "steady.csv"));
  const rows = readFileSync(join(scratch, "steady.csv"), "utf8").trim().split("\n");
  const at = rows[0]?.split(",").indexOf("surge_speed_m_s") ?? -1;
  assert.ok(at > 0, rows[0]);
  const varied = rows.slice(1).map((row, place) => {
    const cells = row.split(",");
    // About a second to and fro, so that both manoeuvres have one speed.
    cells[at] = String(1.6 + 0.6 * Math.sin(place / 3));
    return cells.join(",");
  });
  writeFileSync(join(scratch, "varied.csv"), [rows[0], ...varied].join("\n"));
  const page = await opened("#/history/log", { viewport: { width: 390, height: 844 } });
  await page.locator("input[type=file]").setInputFiles(join(scratch, "varied.csv"));
  await page.getByRole("columnheader", { name: "speed, m/s" }).waitFor();
  await page.getByRole("button", { name: "Identify", exact: true }).click();
  // Windows by hand leave no table of speeds, which would tell one for each.
  await page.getByRole("button", { name: "Identify with these windows" }).click();
  await page.getByText("The speed of the log varies.").waitFor();
  const turning = page.getByRole("region", { name: /^Turning with .* of rudder$/ });
  const cells = await turning.locator("tbody tr").first().locator("td").allInnerTexts();
  assert.match(cells[0] ?? "", /^[01]\.\d+\u00a0m\/s$/);
  assert.match(cells.at(-1) ?? "", /\u00a0m$/);
  // What is to be known of the file is said in the names of the page.
  await written(page, "ArduPilot Rover, .param");
  await page.getByText('say "Rudder at full steering" under').waitFor();
  assert.deepEqual(await violations(page), []);
  await page.context().close();
});

test("a vehicle that is not simulated moves again only when that is agreed to", async () => {
  const page = await opened("#/history/campaign/1");
  await page.route("**/api/v1/campaigns/1", async (route) => {
    const answer = (await (await route.fetch()).json()) as { campaign: object };
    await route.fulfill({ json: { ...answer, campaign: { ...answer.campaign, seed: null, state: "aborted" } } });
  });
  await page.reload();
  const again = page.getByRole("button", { name: "Go on at the next speed" });
  await again.waitFor();
  assert.ok(await again.isDisabled());
  await page.getByLabel("I agree that the vehicle moves again").check();
  assert.ok(await again.isEnabled());
  await page.context().close();
});

test("the faults of a rehearsal are chosen, and the checks stand above Start", async () => {
  const page = await opened("#/control/rehearse", { viewport: { width: 390, height: 844 } });
  await takeControl(page, "Ada");
  await page.getByLabel("Fault to rehearse").selectOption("heavier_payload");
  await page.getByText("three tenths more moment of inertia").waitFor();
  await page.getByLabel("Speeds, thrust").fill("80");
  await page.getByLabel("Pace").selectOption("as fast as it can");
  const check = page.getByRole("button", { name: /^Check/ });
  const start = page.getByRole("button", { name: "Start the trial" });
  const [above, below] = [await check.boundingBox(), await start.boundingBox()];
  assert.ok(above && below && above.y < below.y, JSON.stringify([above, below]));
  await check.click();
  await page.getByText("✓ ready").waitFor();
  await start.click();
  await page.waitForURL(/#\/live$/);
  await page.getByText("ended").first().waitFor();
  await page.goto(`${server.url}#/control`);
  await page.getByRole("button", { name: "Give control back" }).click();
  await page.context().close();
});

/** Regions whose table is wider than they are. */
const cut = (page: Page, within: string): Promise<(string | null)[]> =>
  page.evaluate(
    (selector) =>
      [...document.querySelectorAll(`${selector} .table-box`)]
        .filter((box) => box.scrollWidth > box.clientWidth + 1)
        .map((box) => box.getAttribute("aria-label")),
    within,
  );

test("Live and History say the same of a campaign whose speeds contradict each other", async () => {
  const page = await opened("#/control/rehearse");
  await takeControl(page, "Ada");
  await page.getByLabel("Fault to rehearse").selectOption("broken_fin");
  await page.getByLabel("Speeds, thrust").fill("60, 70, 80");
  await page.getByLabel("Pace").selectOption("as fast as it can");
  await page.getByRole("button", { name: /^Check/ }).click();
  await page.getByRole("button", { name: "Start the trial" }).click();
  await page.waitForURL(/#\/live$/);
  const notice = page.getByRole("region", { name: "What is going on" });
  await notice.locator(".loud", { hasText: "The trial is finished" }).waitFor();
  const said = await notice.locator("p").allInnerTexts();
  assert.equal(said[1], "✗ Do not use.");
  assert.ok(said.includes("0 of 3 speeds have a usable model."), said.join("\n"));
  assert.equal(await page.locator(".speeds .accepted").count(), 0);
  const estimate = await page.getByText(/a₂₂ = /).innerText();

  await page.getByRole("link", { name: "Control", exact: true }).click();
  const live = page.getByRole("region", { name: "Runs", exact: true });
  const { campaign } = (await server.trial()) as unknown as { campaign: number };
  const other = await opened(`#/history/campaign/${campaign}`);
  const kept = other.getByRole("region", { name: "Runs", exact: true });
  await kept.waitFor();
  assert.equal(await live.innerText(), await kept.innerText());
  await other.getByText("✗ Do not use.", { exact: true }).waitFor();
  // Nothing of it can be looked at over speed or taken before its refusal is read.
  const files = other.getByRole("region", { name: "Gains and limits" });
  await files.getByText("No file is written before you have read this").waitFor();
  const param = files.getByRole("button", { name: "ArduPilot Rover, .param" });
  assert.ok(await param.isDisabled());
  assert.equal(await other.getByRole("slider").count(), 0);
  await files.getByLabel("I have read this").check();
  await files.getByRole("region", { name: "Gains", exact: true }).waitFor();
  assert.ok(await param.isEnabled());
  // The last run, in the page's words and in the table.
  const [value = "", interval = ""] = (await kept.locator("tr").last().locator("td").nth(4).innerText()).split("\n");
  assert.ok(estimate.includes(`a₂₂ = ${value} ${interval},`), `${estimate}: ${value} ${interval}`);
  await other.goto(`${server.url}#/history`);
  const row = other.locator("tr", { has: other.getByRole("link", { name: `No. ${campaign}`, exact: true }) });
  await row.waitFor();
  const cells = await row.locator("td").allInnerTexts();
  assert.ok(cells.indexOf("✗ do not use") >= 0, cells.join());
  assert.ok(cells.indexOf("✗ do not use") < cells.indexOf("3 of 3"), cells.join());
  await other.context().close();
  await page.getByRole("button", { name: "Give control back" }).click();
  await page.context().close();
});

test("a phone shows what is chosen, what was judged and what changed without a sideways scroll", async () => {
  const page = await opened("#/history", { viewport: { width: 390, height: 844 } });
  const right = async (selector: string): Promise<number> => {
    const last = page.locator(selector).last();
    await last.waitFor();
    const box = await last.boundingBox();
    return (box?.x ?? Infinity) + (box?.width ?? 0);
  };
  assert.ok((await right("input[aria-label^='B campaign']")) <= 390);
  // Both ran at 80 %; the second is not to be used.
  await page.getByLabel("B campaign 3", { exact: true }).check();
  await page.getByLabel("A campaign 4", { exact: true }).check();
  await page.getByRole("button", { name: "Compare A with B" }).click();
  await page.locator(".compared table").first().waitFor();
  assert.deepEqual(await cut(page, ".compared"), []);
  await page.goto(`${server.url}#/history/campaign/${page.url().split("/").at(-1)}`);
  assert.ok((await right("td.good, td.partly, td.bad")) <= 390);
  await page.getByRole("region", { name: /^Turning with .* of rudder$/ }).waitFor();
  assert.deepEqual(await cut(page, "[aria-label='Gains and limits']"), []);
  await page.context().close();
});

test("what is read from the logbook is said to be read until it is there", async () => {
  const page = await opened("#/control");
  let answer = (): void => undefined;
  const asked = new Promise<void>((heard) => {
    void page.route("**/api/v1/campaigns", async (route) => {
      heard();
      await new Promise<void>((go) => (answer = go));
      await route.continue();
    });
  });
  await page.getByRole("link", { name: "History", exact: true }).click();
  await asked;
  await page.getByRole("status").filter({ hasText: "Reading the logbook" }).waitFor();
  answer();
  await page.getByRole("region", { name: "Campaigns" }).waitFor();
  assert.equal(await page.getByText("Reading the logbook").count(), 0);
  await page.context().close();
});

const commission = {
  ...{ running: false, vehicle: "mavlink:udp:0.0.0.0:14550", campaign: 1, started: "2026-05-01T10:00:00Z" },
  ...{ ended: "kept", line: "KEPT the new gains", undo: "seatrial vehicle restore", needs_restoring: false },
  ...{ stages: [] as string[], old: null, new: null },
  proposed: {
    parameters: [
      { name: "ATC_STR_RAT_FF", from: 0.2, to: 6.14, why: "the steering of a steady turn, by the model of the trial" },
      { name: "ATC_STR_ANG_P", from: 2, to: 0.356, why: "so that a course change overshoots by at most 5 degrees" },
    ],
  },
};

/** A page that is told of a commission; the function tells it of another state of the same. */
async function toldOf(
  first: typeof commission,
  width: number,
): Promise<{ page: Page; tell(now: typeof commission): void }> {
  let now = first;
  let tell = (): void => undefined;
  const page = await opened("#/live", { viewport: { width, height: 900 } });
  await page.route("**/api/v1/commission?after=*", (route) =>
    route.fulfill({ json: { commission: now, samples: [], next: 0 } }),
  );
  await page.routeWebSocket(/api\/v1\/live$/, (socket) => {
    let sequence = 0;
    tell = () => socket.send(JSON.stringify({ type: "commission", sequence, commission: now }));
    socket.connectToServer().onMessage((message) => {
      const heard = JSON.parse(String(message)) as Record<string, unknown>;
      sequence = Number(heard["sequence"]);
      socket.send(JSON.stringify(heard["type"] === "snapshot" ? { ...heard, commission: now } : heard));
    });
  });
  await page.goto(`${server.url}#/commission`);
  await page.reload();
  return { page, tell: (state) => ((now = state), tell()) };
}

test("what a commission did is read whole, on a phone and on a laptop", async () => {
  const stages = Array.from({ length: 6 }, (_, at) => `step ${at + 1} to starboard with the old gains, measured twice`);
  for (const width of [390, 1440]) {
    const { page } = await toldOf({ ...commission, stages }, width);
    const told = page.getByRole("list", { name: "What was done" }).getByRole("listitem");
    await told.nth(stages.length - 1).waitFor();
    const shown = await told.evaluateAll((items) =>
      items.map((item) => item.scrollWidth <= item.clientWidth && item.getBoundingClientRect().width > 200),
    );
    assert.deepEqual(
      shown,
      stages.map(() => true),
      `${width}`,
    );
    const why = page.getByRole("cell", { name: commission.proposed.parameters[0]?.why ?? "" });
    const [reason, table] = [await why.boundingBox(), await page.locator("table", { has: why }).boundingBox()];
    assert.ok(reason && table && reason.width > 0.9 * table.width, JSON.stringify([width, reason, table]));
    await page.context().close();
  }
});

test("a proposal is read before Start, also beside what a commission did", async () => {
  const expected = { overshoot: [0.6, 0.7], settling_s: [30, 32], rudder_per_s: [0.1, 0.2] };
  const proposed = {
    ...commission.proposed,
    ...{ proposal: "x", surge_speed_m_s: 1, step_rad: 0.5, duration_s: 60, distance_m: 60 },
    ...{ old_expected: expected, new_expected: expected },
  };
  const { page } = await toldOf(commission, 390);
  const name = commission.vehicle;
  await page.route("**/api/v1/vehicles", (route) =>
    route.fulfill({
      json: { vehicles: [{ name, description: "", is_simulated: false, has_gains: true }], scenarios: [] },
    }),
  );
  await page.route("**/api/v1/commission/preview", (route) =>
    route.fulfill({ json: { ready: true, checks: [], changes: [], refused: null, proposed } }),
  );
  await page.reload();
  await page.getByLabel("Use models of a rehearsal as well").check();
  await page.getByRole("button", { name: "Look at the autopilot" }).click();
  const read = page.getByRole("region", { name: "Parameters proposed" });
  await read.waitFor();
  const start = await page.getByRole("button", { name: "Start the heading steps" }).boundingBox();
  const table = await read.boundingBox();
  assert.ok(start && table && table.y + table.height < start.y, JSON.stringify([table, start]));
  assert.deepEqual(await violations(page), []);
  await page.context().close();
});

test("after an undo the page says that the old gains are in use, with what was tried", async () => {
  const { page, tell } = await toldOf(commission, 390);
  await page.getByText("✓ The new gains stay").waitFor();
  const inUse = page.locator("th", { hasText: "in use now" });
  assert.equal((await inUse.innerText()).split("\n")[0], "new");
  tell({ ...commission, ended: "put_back", line: "an undo has put the old gains back", undo: "" });
  const told = page.getByRole("status", { name: "What came of it" });
  await told.getByText("The old gains are back").waitFor();
  assert.match(await told.innerText(), /An undo has put the old gains back\./);
  assert.equal((await inUse.innerText()).split("\n")[0], "before");
  assert.deepEqual(await violations(page), []);
  await page.context().close();
});
