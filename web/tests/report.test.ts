//! The report as it is read: on paper, on a phone, in both themes.

import assert from "node:assert/strict";
import { statSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import type { Browser, Page } from "playwright-core";
import { violations } from "./axe.ts";
import { forget, openBrowser, scratch, seatrial } from "./server.ts";

/** Of a trial of five speeds and of a log, bytes. */
const LARGEST = { trial: 560_000, log: 110_000 } as const;
/** Pages of A4. */
const MOST_PAGES = { trial: 6, log: 2 } as const;
const MOST_SCREENS = 10;
const PHONE = { width: 390, height: 844 };

let browser: Browser;
const file = (name: string): string => join(scratch, `${name}.html`);

before(async () => {
  seatrial("trial", "--yes", "--logbook", join(scratch, "report.db"), "--report", file("trial"));
  const log = join(scratch, "report.csv");
  seatrial("sim", "log", "--seed", "3", "--thrust", "0.8", "--out", log);
  seatrial("report", log, "--out", file("log"));
  browser = await openBrowser();
});

after(async () => {
  await browser?.close();
  forget();
});

async function opened(name: string, viewport = { width: 1440, height: 1000 }): Promise<Page> {
  const page = await (await browser.newContext({ viewport })).newPage();
  await page.goto(pathToFileURL(file(name)).href);
  return page;
}

for (const name of ["trial", "log"] as const) {
  test(`the report of a ${name} prints on few pages and is small`, async () => {
    const page = await opened(name);
    const pdf = (await page.pdf({ format: "A4" })).toString("latin1");
    const pages = pdf.match(/\/Type\s*\/Page[^s]/g)?.length ?? 0;
    const { size } = statSync(file(name));
    console.log(`${name}: ${pages} pages, ${(size / 1000).toFixed(0)} kB`);
    assert.ok(pages >= 1 && pages <= MOST_PAGES[name], `${pages} pages`);
    assert.ok(size <= LARGEST[name], `${size} bytes`);
    await page.context().close();
  });

  test(`the report of a ${name} fits a phone`, async () => {
    const page = await opened(name, PHONE);
    const [width, height] = await page.evaluate(() => [
      document.documentElement.scrollWidth,
      document.documentElement.scrollHeight,
    ]);
    const screens = Number(height) / PHONE.height;
    console.log(`${name}: ${screens.toFixed(1)} screens of a phone`);
    assert.ok(Number(width) <= PHONE.width, `${width} px wide`);
    assert.ok(screens <= MOST_SCREENS, `${screens} screens`);
    await page.context().close();
  });

  test(`the report of a ${name} has no violation of axe-core in either theme`, async () => {
    for (const viewport of [undefined, PHONE]) {
      for (const colorScheme of ["light", "dark"] as const) {
        const page = await opened(name, viewport);
        await page.emulateMedia({ colorScheme });
        assert.deepEqual(await violations(page), [], colorScheme);
        await page.context().close();
      }
    }
  });
}
