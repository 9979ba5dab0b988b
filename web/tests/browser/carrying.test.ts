import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import type { Browser } from "playwright-core";
import type { PageData } from "../../src/data/page_data.ts";
import { angleBetween, compose, distanceBetween, inverse } from "../../src/motion/pose.ts";
import { CLOSED_S, CLOSES_S, ENDS_S, LIFTED_S, carriedPage, recordedPage } from "../fixtures/carried_page.ts";
import { twoJointPage } from "../fixtures/two_joint_page.ts";
import { launch, look, type Opened, open, picture, rest, serve } from "./browser.ts";
import { difference } from "./pixels.ts";

let browser: Browser;
before(async () => {
  browser = await launch();
});
after(() => browser.close());

async function withPage(
  data: PageData,
  body: (opened: Opened) => Promise<void>,
  options: Parameters<typeof open>[2] = {},
): Promise<void> {
  const server = await serve(data);
  const opened = await open(browser, server.address, options);
  try {
    await body(opened);
    assert.deepEqual(opened.complaints, []);
  } finally {
    await opened.page.context().close();
    await server.close();
  }
}

async function seek({ page }: Opened, time_s: number): Promise<void> {
  await page.getByRole("slider", { name: "Time along the path" }).fill(String(time_s));
  await rest(page);
}

test("the time line says what the robot does, and what is pressed shows its beginning", () =>
  withPage(carriedPage(), async (opened) => {
    const { page } = opened;
    const marks = page.getByRole("group", { name: "What the robot does" });
    assert.deepEqual(await marks.getByRole("button").allTextContents(), ["reach", "close", "lift-off", "carry"]);
    for (const name of ["reach", "lift-off", "carry"]) assert.ok(await marks.getByText(name).isVisible(), name);
    for (const [time, mode] of [
      [0.5, "reach"],
      [1.2, "close"],
      [1.6, "lift-off"],
      [2.5, "carry"],
    ] as const) {
      await seek(opened, time);
      assert.equal(await look(page, "mode"), mode);
      assert.deepEqual(await marks.locator("[aria-current]").allTextContents(), [mode]);
      await picture(page, `carried_${mode}`);
    }
    await marks.getByText("carry").click();
    assert.ok(Math.abs((await look(page, "time")) - LIFTED_S) < 1e-3);
    await marks.getByRole("button", { name: "The hand closes" }).click();
    assert.equal(await look(page, "mode"), "close");
    // Each mark's width is proportional to its duration.
    const [reach, carry] = await Promise.all(
      ["reach", "carry"].map((name) => marks.getByRole("button", { name: `beginning of ${name}` }).boundingBox()),
    );
    assert.ok(Math.abs(reach!.width / carry!.width - CLOSES_S / (ENDS_S - LIFTED_S)) < 0.05);
  }));

test("the object stands until the hand has closed, and then goes with it", () =>
  withPage(carriedPage(), async (opened) => {
    const { page } = opened;
    const standing = await look(page, "worldFromTarget");
    await seek(opened, CLOSES_S);
    const held = compose(inverse(await look(page, "worldFromGripper")), standing!);
    await seek(opened, (CLOSES_S + CLOSED_S) / 2);
    assert.deepEqual(await look(page, "worldFromTarget"), standing);
    for (const time of [1.6, 2.2, ENDS_S]) {
      await seek(opened, time);
      const [target, gripper] = [await look(page, "worldFromTarget"), await look(page, "worldFromGripper")];
      const expected = compose(gripper, held);
      assert.ok(distanceBetween(target!, expected) < 1e-9 && angleBetween(target!, expected) < 1e-6, `${time}`);
    }
    assert.ok(distanceBetween((await look(page, "worldFromTarget"))!, standing!) > 0.3);
    // After posing by hand, the hand is empty.
    await page.getByText("Joints", { exact: true }).click();
    await page.getByRole("slider", { name: "elbow" }).fill("0.2");
    assert.deepEqual(await look(page, "worldFromTarget"), standing);
  }));

test("poses on the way, and those of other plans, have the object too", () =>
  withPage(carriedPage({ plans: 2 }), async (opened) => {
    const { page } = opened;
    await seek(opened, 0);
    const without = await page.screenshot();
    await page.keyboard.press("o");
    await rest(page);
    assert.ok((await difference(browser, without, await page.screenshot())) > 0.005);
    await picture(page, "carried_ghosts");
    await page.keyboard.press("]");
    await seek(opened, 2.2);
    assert.deepEqual([await look(page, "plan"), await look(page, "mode")], [1, "carry"]);
  }));

test("a plan that only reaches has no marks", () =>
  withPage(twoJointPage(), async ({ page }) => {
    assert.equal(await page.getByRole("group", { name: "What the robot does" }).count(), 0);
    assert.equal(await look(page, "mode"), "");
  }));

test("a recording plays and can be scrubbed, with nothing to ask a robot", () =>
  withPage(recordedPage(), async (opened) => {
    const { page } = opened;
    assert.equal(await page.title(), "a target rises · Cranny");
    const panel = page.getByRole("complementary", { name: "Settings" });
    assert.doesNotMatch(await panel.innerText(), /Plan|Joints|Grasps/);
    await seek(opened, 0.5);
    assert.ok(Math.abs((await look(page, "worldFromTarget"))![2] - 0.55) < 1e-9);
    const middle = await page.screenshot();
    await picture(page, "recording");
    await page.keyboard.press("Home");
    await page.getByRole("button", { name: "Play" }).click();
    await page.waitForFunction(() => window.cranny?.isPlaying === false);
    assert.equal(await look(page, "time"), 1);
    assert.ok(Math.abs((await look(page, "worldFromTarget"))![2] - 0.6) < 1e-9);
    assert.ok((await difference(browser, middle, await page.screenshot())) > 0);
  }));

test("a recording shows itself when the page opens", () =>
  withPage(
    recordedPage(),
    async ({ page }) => {
      await page.waitForFunction(() => window.cranny?.isPlaying === false && window.cranny.time === 1);
    },
    { reducedMotion: "no-preference" },
  ));
