import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import type { Browser } from "playwright-core";
import type { PageData } from "../../src/data/page_data.ts";
import { compose, distanceBetween, inverse } from "../../src/motion/pose.ts";
import { CRANNY, launch, look, type Opened, open, picture, rest, view } from "./browser.ts";

/** These tests need the program itself. */
const skip = CRANNY === "" ? "CRANNY_BIN names no program" : false;

let browser: Browser;
let folder: string;

before(async () => {
  if (skip) return;
  folder = mkdtempSync(join(tmpdir(), "cranny-carry-"));
  browser = await launch();
});

after(async () => {
  if (skip) return;
  await browser.close();
  rmSync(folder, { recursive: true });
});

async function withView(args: string[], body: (opened: Opened, data: PageData) => Promise<void>): Promise<void> {
  const server = await view(...args);
  const opened = await open(browser, server.address);
  try {
    await body(opened, (await (await fetch(`${server.address}page.json`)).json()) as PageData);
    assert.deepEqual(opened.complaints, []);
  } finally {
    await opened.page.context().close();
    assert.equal(await server.stop(), 0);
  }
}

test("the object of a plan goes home in the hand, and postures are judged with it", { skip }, () => {
  const plan = join(folder, "home.plan.json");
  execFileSync(CRANNY, ["plan", "031", "--carry", "home", "-o", plan, "--quiet"]);
  return withView(["031", plan], async ({ page }, data) => {
    const seek = async (time_s: number): Promise<void> => {
      await page.getByRole("slider", { name: "Time along the path" }).fill(String(time_s));
      await rest(page);
    };
    const [reach, , carry] = data.plans[0].carries[0].modes;
    const standing = (await look(page, "worldFromTarget"))!;
    await seek(reach.until_s);
    const held = compose(inverse(await look(page, "worldFromGripper")), standing);
    await page.getByText("Joints", { exact: true }).click();
    for (const time of [carry.from_s + 0.01, (carry.from_s + carry.until_s) / 2, carry.until_s]) {
      await seek(time);
      const target = compose(await look(page, "worldFromGripper"), held);
      assert.ok(distanceBetween((await look(page, "worldFromTarget"))!, target) < 1e-9, `at ${time}`);
      await page.waitForFunction(() => window.cranny?.standing.kind === "known");
      const standing = await look(page, "standing");
      assert.ok(standing.kind === "known" && standing.verdict.is_free, JSON.stringify(standing));
    }
    await picture(page, "live_carried");
    assert.ok(data.plans[0].clearance!.pairs.some(({ first }) => first === "box"));
  });
});

test("the steps of a plan are one motion, and postures are judged in the world that the steps before leave", { skip }, () => {
  const plan = join(folder, "steps.plan.json");
  execFileSync(CRANNY, ["plan", "235", "--steps", "-o", plan, "--quiet"]);
  return withView(["235", plan], async ({ page }, data) => {
    const { carries } = data.plans[0];
    assert.ok(data.plans[0].is_valid && carries.length > 1);
    assert.ok(new Set(carries.map(({ object }) => object)).size > 1);
    assert.deepEqual(await page.getByRole("switch", { name: "Places" }).isChecked(), true);
    await page.getByText("Joints", { exact: true }).click();
    const standing = (await look(page, "worldFromTarget"))!;
    for (const [index, { modes, object }] of carries.entries()) {
      for (const { name, from_s, until_s } of modes) {
        await page.getByRole("slider", { name: "Time along the path" }).fill(String((from_s + until_s) / 2));
        await rest(page);
        assert.equal(await look(page, "mode"), name);
        await page.waitForFunction(() => window.cranny?.standing.kind === "known");
        const judged = await look(page, "standing");
        const isFree = judged.kind === "known" && judged.verdict.is_free;
        // During lift-off and set-down, the object touches its support.
        assert.ok(isFree || ["lift-off", "set-down"].includes(name), `${object}, ${name}: ${JSON.stringify(judged)}`);
      }
      // The same holds while the hand closes.
      await page.getByRole("slider", { name: "Time along the path" }).fill(String(modes[0].until_s + 0.01));
      await page.waitForFunction(() => window.cranny?.standing.kind === "known" && window.cranny.mode === "close");
      await page.getByRole("slider", { name: "Time along the path" }).fill(String(modes.at(-1)!.until_s));
      await rest(page);
      const isLast = index === carries.length - 1;
      assert.equal(distanceBetween((await look(page, "worldFromTarget"))!, standing) > 0.5, isLast);
    }
    await picture(page, "live_steps");
  });
});

test("a recording plays", { skip }, () => {
  const file = join(folder, "run.json");
  const body = {
    name: "tile",
    is_grasped: true,
    world_from_body: [
      [0, 0, 0, 0, 0, 0, 1],
      [0, 0, 0.1, 0, 0, 0, 1],
    ],
    vertices: [
      [0, 0, 0],
      [0.1, 0, 0],
      [0, 0.1, 0],
    ],
    triangles: [[0, 1, 2]],
  };
  const recording = { format: "cranny-recording/1", name: "a tile rises", times_s: [0, 0.5], bodies: [body] };
  writeFileSync(file, JSON.stringify(recording));
  return withView([file], async ({ page }) => {
    await page.keyboard.press(" ");
    await page.waitForFunction(() => window.cranny?.isPlaying === false && window.cranny.time === 0.5);
    assert.ok(Math.abs((await look(page, "worldFromTarget"))![2] - 0.1) < 1e-9);
  });
});
