import assert from "node:assert/strict";
import { execFileSync, spawnSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import type { Browser, Locator, Page } from "playwright-core";
import type { PageData } from "../../src/data/page_data.ts";
import { LIFTED_S } from "../fixtures/carried_page.ts";
import { failedTaskPage, solvedTaskPage } from "../fixtures/staged_page.ts";
import { twoJointPage } from "../fixtures/two_joint_page.ts";
import { CRANNY, launch, look, type Opened, open, picture, rest, serve, view } from "./browser.ts";

/** Tests of the program's own page need the program. */
const skip = CRANNY === "" ? "CRANNY_BIN names no program" : false;

let browser: Browser;
before(async () => {
  browser = await launch();
});
after(() => browser.close());

async function withPage(data: PageData, body: (opened: Opened) => Promise<void>): Promise<void> {
  const server = await serve(data);
  const opened = await open(browser, server.address);
  try {
    await body(opened);
    assert.deepEqual(opened.complaints, []);
  } finally {
    await opened.page.context().close();
    await server.close();
  }
}

function stagesOf(page: Page): Locator {
  return page.locator(".stages");
}

test("the stages of a task are listed, and a pressed one shows its beginning", () =>
  withPage(solvedTaskPage(), async ({ page }) => {
    await page.getByText("Stages (2)", { exact: true }).waitFor();
    const stages = stagesOf(page);
    const text = await stages.innerText();
    for (const part of ["Pick 'target'", "Move home", "done", "0.00 to 1.80 s", "clearance at least 12.3 mm", "3 goals"]) {
      assert.ok(text.includes(part), `${text} lacks ${part}`);
    }
    assert.match(text, /keeps the alternative that succeeded, not those that failed/);
    await stages.getByRole("button", { name: "Move home" }).click();
    await rest(page);
    assert.ok(Math.abs((await look(page, "time")) - LIFTED_S) < 1e-3);
    assert.equal(await look(page, "mode"), "carry");
    const current = stages.locator("[aria-current=step]");
    assert.match(await current.innerText(), /Move home/);
    await picture(page, "stages_solved");
    await stages.getByRole("button", { name: "Pick 'target'" }).click();
    await rest(page);
    assert.equal(await look(page, "time"), 0);
    assert.match(await current.innerText(), /Pick/);
    await stages.getByRole("button", { name: "Show grasp 0" }).click();
    assert.equal(await look(page, "grasp"), 0);
  }));

test("a task without a path says where it failed, and why each grasp failed", () =>
  withPage(failedTaskPage(), async ({ page }) => {
    const stages = stagesOf(page);
    const text = await stages.innerText();
    assert.match(text, /The search failed at stage 2 of 3: put down in 'shelf'/);
    assert.match(text, /24 grasps were checked, and none led through all stages/);
    const items = stages.getByRole("listitem");
    const told = await items.allInnerTexts();
    assert.match(told[0], /some passed[^]*✕ 16 failed[^]*✓ 8 left[^]*Whatever the arm does, hand collides with table at the exact pose[^]*8/);
    assert.match(told[1], /failed here[^]*✕ 8 failed[^]*✓ 0 left[^]*no path to the placement/);
    assert.match(told[2], /not reached/);
    assert.doesNotMatch(told[2], /failed/);
    // Without a path there is no beginning to show.
    assert.equal(await stages.getByRole("button", { name: "Move home" }).count(), 0);
    await picture(page, "stages_failed");
  }));

test("a grasp in the list of a reason shows itself in the scene", () =>
  withPage(failedTaskPage(), async ({ page }) => {
    const stages = stagesOf(page);
    await stages.getByText("no path to the placement").click();
    const chip = stages.getByRole("button", { name: "Show grasp 5 in the scene" });
    await chip.click();
    await rest(page);
    assert.equal(await look(page, "grasp"), 5);
    assert.equal(await chip.getAttribute("aria-pressed"), "true");
    const tip = page.getByRole("tooltip");
    assert.match(await tip.innerText(), /Grasp 5[^]*blocked[^]*not connected/);
    const [told, panel] = [await tip.boundingBox(), await page.getByRole("complementary").boundingBox()];
    assert.ok(told && panel && told.x + told.width <= panel.x, "the panel hides what is told of the grasp");
    await picture(page, "stages_grasp");
  }));

test("the stages shown are those of the chosen plan", () => {
  const staged = solvedTaskPage();
  const data = { ...staged, plans: [...staged.plans, ...twoJointPage().plans] };
  return withPage(data, async ({ page }) => {
    assert.equal(await stagesOf(page).getByRole("listitem").count(), 2);
    await page.keyboard.press("]");
    assert.match(await stagesOf(page).innerText(), /This plan has no list of stages/);
  });
});

test("a plan without a list of stages has no such panel", () =>
  withPage(twoJointPage(), async ({ page }) => {
    assert.equal(await stagesOf(page).count(), 0);
  }));

test("the program's page lists the stages of its plan files", { skip }, async () => {
  const folder = mkdtempSync(join(tmpdir(), "cranny-stages-"));
  const [put, weak] = [join(folder, "put.plan.json"), join(folder, "weak.plan.json")];
  execFileSync(CRANNY, ["plan", "031", "--place", "outside", "-o", put, "--quiet"]);
  // No grasp holds the box under nine times its weight.
  const failed = spawnSync(CRANNY, ["plan", "035", "--carry", "home", "--hold", "9", "-o", weak, "--quiet"]);
  assert.equal(failed.status, 1, String(failed.stderr));
  try {
    for (const [id, plan, parts] of [
      ["031", put, [/Pick 'target'/, /Put down in 'outside'/, /Move home/, /All stages have a path/]],
      ["035", weak, [/failed at stage 1 of 2: pick 'target'/, /✕ 200 failed/, /holds the object too weakly/, /not reached/]],
    ] as const) {
      const server = await view(id, plan);
      const opened = await open(browser, server.address, { viewport: { width: 1280, height: 900 } });
      const text = await stagesOf(opened.page).innerText();
      for (const part of parts) assert.match(text, part);
      if (plan === put) {
        await stagesOf(opened.page).getByRole("button", { name: "Put down" }).click();
        await rest(opened.page);
        assert.equal(await look(opened.page, "mode"), "carry");
      }
      await picture(opened.page, `stages_${id}`);
      assert.deepEqual(opened.complaints, []);
      await opened.page.context().close();
      assert.equal(await server.stop(), 0);
    }
  } finally {
    rmSync(folder, { recursive: true });
  }
});
