import assert from "node:assert/strict";
import { execFileSync, spawnSync } from "node:child_process";
import { mkdtempSync, rmSync, statSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import type { Browser } from "playwright-core";
import type { PageData, Verdict } from "../../src/data/page_data.ts";
import { angleBetween, distanceBetween } from "../../src/motion/pose.ts";
import { CRANNY, launch, look, type Opened, open, picture, rest, view } from "./browser.ts";
import { difference } from "./pixels.ts";

/** These tests need the program itself. */
const skip = CRANNY === "" ? "CRANNY_BIN names no program" : false;

const SCENARIO = "021";

/** Tolerance between page and program, in metres and radians. */
const SAME = 1e-6;

/** The criterion `exact`, plus the rounding of a plan's last digits. */
const ARRIVED_M = 1.001e-3;
const ARRIVED_RAD = (1.001 * Math.PI) / 180;

/** Size limit of a page that is shared as one file. */
const MOST_BYTES = 3_000_000;

let browser: Browser;
let folder: string;
let plan: string;
let server: Awaited<ReturnType<typeof view>>;

before(async () => {
  if (skip) return;
  folder = mkdtempSync(join(tmpdir(), "cranny-view-"));
  plan = join(folder, "reach.plan.json");
  execFileSync(CRANNY, ["plan", SCENARIO, "-o", plan, "--quiet"]);
  browser = await launch();
  server = await view(SCENARIO, plan);
});

after(async () => {
  if (skip) return;
  await browser.close();
  assert.equal(await server.stop(), 0);
  rmSync(folder, { recursive: true });
});

async function withPage(
  body: (opened: Opened, data: PageData) => Promise<void>,
  address = server.address,
): Promise<void> {
  const opened = await open(browser, address);
  try {
    const data = (await (await fetch(`${server.address}page.json`)).json()) as PageData;
    await body(opened, data);
    assert.deepEqual(opened.complaints, []);
  } finally {
    await opened.page.context().close();
  }
}

async function judged(q: number[]): Promise<Verdict> {
  const answer = await fetch(`${server.address}verdict`, {
    method: "POST",
    headers: { "content-type": "application/json" },
    body: JSON.stringify({ q }),
  });
  return (await answer.json()) as Verdict;
}

test("the program's page shows its scene, and says how long that took", { skip }, () =>
  withPage(async ({ page }) => {
    console.log(`loading ${SCENARIO} and its plan: ${(await look(page, "loadMs")).toFixed(0)} ms to the first frame`);
    const scene = await page.screenshot();
    await picture(page, "live");
    for (const key of ["v", "g", "p", "d"]) await page.keyboard.press(key);
    await rest(page);
    assert.ok((await difference(browser, scene, await page.screenshot())) > 0.05);
  }),
);

test("the page's gripper is that of the program's kinematics, at the end it is at the grasp", { skip }, () =>
  withPage(async ({ page }, data) => {
    const [{ grasp: taken }] = data.plans;
    const grasp = data.grasps.find(({ index }) => index === taken)!.world_from_gripper;
    let worst = 0;
    const compare = async (): Promise<void> => {
      const [q, gripper] = [await look(page, "q"), await look(page, "worldFromGripper")];
      const { world_from_gripper } = await judged(q);
      worst = Math.max(worst, distanceBetween(gripper, world_from_gripper), angleBetween(gripper, world_from_gripper));
    };
    for (const time of ["0", "0.5", "1.234", "2"]) {
      await page.getByRole("slider", { name: "Time along the path" }).fill(time);
      await compare();
    }
    await page.keyboard.press("End");
    await compare();
    console.log(`page and program differ by ${worst.toExponential(1)} m and rad at most`);
    assert.ok(worst < SAME, `${worst}`);
    const gripper = await look(page, "worldFromGripper");
    assert.ok(distanceBetween(gripper, grasp) < ARRIVED_M);
    // With a parallel gripper, half a turn about the approach axis gives the same grasp.
    const turn = angleBetween(gripper, grasp);
    assert.ok(Math.min(turn, Math.PI - turn) < ARRIVED_RAD, `${turn}`);
  }),
);

test("play moves the robot, and a grasp that is pointed at says its score", { skip }, () =>
  withPage(async ({ page }, data) => {
    const start = await look(page, "worldFromGripper");
    await page.keyboard.press(" ");
    await page.waitForFunction(() => (window.cranny?.time ?? 0) > 0.5);
    await page.keyboard.press(" ");
    assert.ok(distanceBetween(start, await look(page, "worldFromGripper")) > 0.01);
    await page.keyboard.press("e");
    await rest(page);
    const { x, y } = await page.evaluate(() => window.cranny!.graspOnScreen(50));
    await page.mouse.move(x, y);
    await page.getByRole("tooltip").waitFor();
    const pointed = await look(page, "grasp");
    const { score } = data.grasps.find(({ index }) => index === pointed)!;
    const said = await page.getByRole("tooltip").innerText();
    assert.ok(said.includes(score === null ? "—" : score.toFixed(2)), said);
  }),
);

test("a slider turns the verdict red where cranny verify says contact", { skip }, () =>
  withPage(async ({ page }, data) => {
    await page.getByText("Joints", { exact: true }).click();
    await page.locator('.verdict[data-kind="free"]').waitFor();
    await page.getByRole("slider", { name: "base_joint_x" }).fill("0.9");
    await page.locator('.verdict[data-kind="contact"]').waitFor();
    await rest(page);
    await picture(page, "live_contact");
    const standing = await look(page, "standing");
    assert.equal(standing.kind, "known");
    const { contacts } = (standing as { verdict: Verdict }).verdict;
    // The same posture as a path that moves there and stays: its last edge has the same contacts as the posture.
    const path = join(folder, "contact.csv");
    const q = await look(page, "q");
    writeFileSync(path, [data.robot.start, q, q].map((row) => row.join(",")).join("\n"));
    const said = spawnSync(CRANNY, ["verify", SCENARIO, path, "--json"], { encoding: "utf8" });
    const { violations } = JSON.parse(said.stdout) as {
      violations: { kind: string; edge: number; first: string; second: string }[];
    };
    const touching = violations.filter(({ kind, edge }) => kind === "contact" && edge === 1);
    const pairs = (all: { first: string; second: string }[]): string[] =>
      all.map(({ first, second }) => [first, second].sort().join(" – ")).sort();
    assert.ok(touching.length > 0, said.stdout);
    assert.deepEqual(pairs(contacts), pairs(touching));
  }),
);

test("what cranny render writes as one file works from disk", { skip }, async () => {
  const file = join(folder, "out.html");
  execFileSync(CRANNY, ["render", SCENARIO, plan, "-o", file, "--quiet"]);
  const { size } = statSync(file);
  console.log(`one file of ${SCENARIO} and its plan: ${(size / 1e6).toFixed(2)} MB`);
  assert.ok(size < MOST_BYTES);
  await withPage(async ({ page }, data) => {
    await page.keyboard.press("End");
    const last = await look(page, "worldFromGripper");
    const grasp = data.grasps.find(({ index }) => index === data.plans[0].grasp)!.world_from_gripper;
    assert.ok(distanceBetween(last, grasp) < ARRIVED_M);
    assert.equal((await look(page, "standing")).kind, "not-live");
  }, pathToFileURL(file).href);
});
