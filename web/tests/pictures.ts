//! The pictures of docs/dashboard.md, over real trials on the simulator: `npm run pictures`.

import type { Page } from "playwright-core";
import { forget, openBrowser, PATIENCE_MS, serve, until } from "./server.ts";

const FOLDER = "../docs/dashboard";
/** Into the training, when the intervals have closed in, s. */
const SURE_AFTER_S = 9;

const server = await serve("pictures.db", "--listen", "127.0.0.1:0");
const browser = await openBrowser();
try {
  const page = await opened(1440, 1000);
  await page.goto(`${server.url}#/control`);
  await page.getByLabel("Your name").fill("Ada");
  await page.getByRole("button", { name: "Take control" }).click();
  await page.getByText("You have control, as Ada.").waitFor();
  for (const [vehicle, configuration] of [
    ["sim:starfish", "bare"],
    ["sim:starfish-6dof", "sonar"],
  ] as const) {
    await prepare(page, vehicle, "60, 80", configuration, "as fast as it can");
    await page.getByRole("button", { name: "Start the trial" }).click();
    await page.getByText(`${vehicle} · ${configuration} · ended`).waitFor();
  }
  await page.goto(`${server.url}#/history/compare/1/2`);
  await page.getByRole("heading", { name: "60 % thrust" }).waitFor();
  await page.getByLabel("Theme").selectOption("dark");
  await page.screenshot({ path: `${FOLDER}/compare-dark.png` });
  await page.getByLabel("Theme").selectOption("light");

  const phone = await opened(390, 844);
  await phone.goto(`${server.url}#/live`);
  await phone.getByLabel("Theme").selectOption("sunlight");
  await prepare(page, "sim:starfish", "60, 70, 80, 90, 100", "sonar", "real time × 10");
  // From who has control down to Start.
  await page.setViewportSize({ width: 1440, height: 1510 });
  await page.evaluate(() => scrollTo(0, 0));
  await page.screenshot({ path: `${FOLDER}/control.png` });
  await page.setViewportSize({ width: 1440, height: 1000 });
  await page.getByRole("button", { name: "Start the trial" }).click();
  await page.locator(".loud", { hasText: "Speed 3 of 5" }).waitFor({ timeout: 6 * PATIENCE_MS });
  await page.locator(".stages .train.now").waitFor();
  await until("the intervals have closed in", async () => {
    const { progress } = await server.trial();
    return progress?.stage === "train" && progress.elapsed_s > SURE_AFTER_S;
  });
  await page.screenshot({ path: `${FOLDER}/live.png` });
  await phone.screenshot({ path: `${FOLDER}/live-phone-sunlight.png` });
  await page.getByLabel("Theme").selectOption("dark");
  await page.screenshot({ path: `${FOLDER}/live-dark.png` });
  await page.keyboard.press(".");
} finally {
  await browser.close();
  await server.stop();
  forget();
}

async function opened(width: number, height: number): Promise<Page> {
  const page = await (await browser.newContext({ viewport: { width, height } })).newPage();
  page.setDefaultTimeout(PATIENCE_MS);
  return page;
}

async function prepare(
  page: Page,
  vehicle: string,
  thrusts: string,
  configuration: string,
  pace: string,
): Promise<void> {
  await page.goto(`${server.url}#/control`);
  await page.getByLabel("Vehicle").first().selectOption(vehicle);
  await page.getByLabel("Speeds, thrust").fill(thrusts);
  await page.getByLabel("Configuration").fill(configuration);
  await page.getByLabel("Pace").selectOption(pace);
  await page.getByRole("button", { name: /^Check/ }).click();
  await page.getByText("✓ ready").waitFor();
}
