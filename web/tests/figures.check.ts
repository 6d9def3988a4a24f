//! The live figures of the docs: computed where they are read, equal to the terminal, and pictures where nothing can be computed.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import type { Browser, FrameLocator, Page } from "playwright-core";
import { withInterval } from "../src/units.ts";
import { forget, openBrowser, PATIENCE_MS, scratch } from "./server.ts";

const TARGET = process.env["CARGO_TARGET_DIR"] ?? "../target";
const BOOK = process.env["SEATRIAL_BOOK"] ?? `${TARGET}/book`;
const DOCS = "../docs/explanation";
const BINARY = process.env["SEATRIAL"] ?? `${TARGET}/debug/seatrial`;
const PHONE = { width: 390, height: 844 };
const FIGURES = ["intervals", "lag"] as const;
/** a22 of the vehicle that is played, 1/s. */
const TRUTH = -1.07;
/** With this set, the pictures in the docs are made anew instead of compared. */
const MAKES_PICTURES = process.env["SEATRIAL_PICTURES"] === "make";

let browser: Browser;

before(async () => {
  browser = await openBrowser();
});

after(async () => {
  await browser?.close();
  forget();
});

const page = async (figure: string, has = { javaScriptEnabled: true }): Promise<Page> => {
  const context = await browser.newContext({ viewport: PHONE, ...has });
  context.setDefaultTimeout(3 * PATIENCE_MS);
  const opened = await context.newPage();
  await opened.goto(pathToFileURL(join(BOOK, "explanation", `${figure}.html`)).href);
  return opened;
};

/** The figure once it shows the trials of its sliders. */
async function live(opened: Page, before = ""): Promise<{ frame: FrameLocator; whole: string }> {
  const frame = opened.frameLocator("figure[data-live] iframe");
  const root = frame.locator(`.figure[data-whole]:not([data-whole='${before}'])`);
  await root.waitFor();
  return { frame, whole: (await root.getAttribute("data-whole")) ?? "" };
}

interface Parameters {
  readonly a22_per_s: number;
}

interface Document {
  readonly online: Parameters | null;
  readonly refined: (Parameters & { readonly interval_95: { readonly a22_per_s: [number, number] } }) | null;
}

/** What the terminal finds in the log of a trial that the page plays. */
async function terminal(opened: Page, trial: unknown): Promise<Document> {
  const inside = opened.frames().find((frame) => frame.url().includes("seatrial.html"));
  assert.ok(inside !== undefined);
  const csv = await inside.evaluate(async (trial) => {
    const { seatrial } = window as unknown as { seatrial: { ask(request: object): Promise<{ csv: string }> } };
    return (await seatrial.ask({ ask: "simulate", trial })).csv;
  }, trial);
  writeFileSync(join(scratch, "simulated.csv"), csv);
  const done = spawnSync(BINARY, ["identify", "simulated.csv", "--json"], { cwd: scratch, encoding: "utf8" });
  return JSON.parse(done.stdout) as Document;
}

/** The numbers behind the marks, in the order in which they are drawn. */
async function marks(frame: FrameLocator): Promise<(number | null)[][]> {
  const numbers = (of: Element[]): (number | null)[][] =>
    of.map((mark) =>
      ["data-value", "data-low", "data-high"].map((name) => {
        const text = mark.getAttribute(name);
        return text === null ? null : Number(text);
      }),
    );
  return frame.locator("svg [data-value]").evaluateAll(numbers);
}

/** The marks that the documents of the terminal make. */
function expected(figure: string, documents: readonly Document[]): (number | null)[][] {
  return documents.flatMap(({ online, refined }) => {
    const bar = refined === null ? [] : [[refined.a22_per_s, ...refined.interval_95.a22_per_s]];
    const cross = online === null || figure === "intervals" ? [] : [[online.a22_per_s, null, null]];
    return [...cross, ...bar];
  });
}

for (const figure of FIGURES) {
  test(`${figure}: numbers are those of the terminal, and follow the sliders`, async () => {
    const opened = await page(figure);
    const faults: string[] = [];
    const requests: string[] = [];
    opened.on("pageerror", (error) => faults.push(error.message));
    opened.on("request", (request) => requests.push(request.url()));
    const { frame, whole } = await live(opened);
    const said = await frame.locator(".figure-said").textContent();
    await frame.locator("input[name=noise]").fill("0.6");
    const moved = await live(opened, whole);
    const trials = JSON.parse(moved.whole) as unknown[];
    assert.ok(trials.length >= 8, moved.whole);
    assert.notEqual(await frame.locator(".figure-said").textContent(), said);
    const documents: Document[] = [];
    for (const trial of trials) documents.push(await terminal(opened, trial));
    assert.deepEqual(await marks(frame), expected(figure, documents));
    const shown = documents[figure === "lag" ? 3 : 0]?.refined;
    assert.ok(shown);
    const text = withInterval(shown.a22_per_s, shown.interval_95.a22_per_s);
    const sentence = (await frame.locator(".figure-said").textContent()) ?? "";
    assert.ok(sentence.includes(text), `${sentence}: ${text}`);
    const away = requests.filter((url) => !/^(file|blob|data):/.test(url));
    assert.deepEqual(away, []);
    assert.deepEqual(faults, []);
  });

  test(`${figure}: nothing goes beyond a phone's width, and the picture is gone where the figure lives`, async () => {
    const opened = await page(figure);
    await live(opened);
    await opened.locator("figure[data-live] img").waitFor({ state: "hidden" });
    for (const frame of opened.frames()) {
      const [inner, outer] = await frame.evaluate(() => {
        const { scrollWidth, clientWidth } = document.documentElement;
        return [scrollWidth, clientWidth] as const;
      });
      assert.ok(inner <= outer, `${frame.url()}: ${inner} of ${outer}`);
    }
    const inside = opened.frames().find((frame) => frame.url().includes("seatrial.html"));
    const [needed, given] = (await inside?.evaluate(() => [
      Math.ceil(document.querySelector(".figure")?.getBoundingClientRect().bottom ?? 0),
      innerHeight,
    ])) ?? [0, 0];
    assert.ok(needed <= given + 1, `${needed} of ${given} high`);
  });

  test(`${figure}: without scripts the picture stays, and it is that of the figure`, async () => {
    const without = await page(figure, { javaScriptEnabled: false });
    const picture = without.locator("figure[data-live] img");
    assert.ok(await picture.isVisible());
    const opened = await page(figure);
    await live(opened);
    const inside = opened.frames().find((frame) => frame.url().includes("seatrial.html"));
    const drawn = await inside?.evaluate(() => (window as unknown as { figureAsFile(): string }).figureAsFile());
    assert.ok(drawn !== undefined);
    const file = join(DOCS, `${figure}.svg`);
    if (MAKES_PICTURES) writeFileSync(file, drawn);
    else assert.equal(readFileSync(join(BOOK, "explanation", `${figure}.svg`), "utf8"), drawn);
    assert.equal(
      readFileSync(file, "utf8"),
      drawn,
      `${file}: make it anew with SEATRIAL_PICTURES=make cargo xtask docs`,
    );
  });
}

test("what the pages say of their figures holds", async () => {
  const intervals = await live(await page("intervals"));
  assert.match(
    (await intervals.frame.locator(".figure-said").textContent()) ?? "",
    /^19 of 20 intervals hold the truth/,
  );
  const lag = await marks((await live(await page("lag"))).frame);
  const [crosses, bars] = [lag.filter(([, low]) => low === null), lag.filter(([, low]) => low !== null)];
  assert.equal(crosses.length, bars.length);
  assert.ok((crosses.at(-1)?.[0] ?? NaN) > 0.6 * TRUTH, "four tenths of the damping are lost");
  const holds = ([, low, high]: (number | null)[]): boolean => (low ?? NaN) <= TRUTH && TRUTH <= (high ?? NaN);
  assert.ok(bars.every(holds), JSON.stringify(bars));
  const width = (bar: (number | null)[] | undefined): number => (bar?.[2] ?? NaN) - (bar?.[1] ?? NaN);
  assert.ok(width(bars.at(-1)) > 2 * width(bars[0]), JSON.stringify(bars));
});

test("where WebAssembly is off the pictures stay", async () => {
  const other = await openBrowser("--js-flags=--jitless");
  try {
    const opened = await other.newPage({ viewport: PHONE });
    await opened.goto(pathToFileURL(join(BOOK, "explanation", "lag.html")).href);
    assert.equal(await opened.evaluate(() => typeof WebAssembly), "undefined");
    await opened.frameLocator("figure[data-live] iframe").locator(".figure").waitFor({ state: "attached" });
    // Longer than the figure takes where it lives.
    await opened.waitForTimeout(3000);
    assert.ok(await opened.locator("figure[data-live] img").isVisible());
    assert.ok(await opened.locator("figure[data-live] iframe").isHidden());
  } finally {
    await other.close();
  }
});
