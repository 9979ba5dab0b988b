import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import type { Browser, Page } from "playwright-core";
import type { PageData } from "../../src/data/page_data.ts";
import { carriedPage, recordedPage } from "../fixtures/carried_page.ts";
import { failedTaskPage, solvedTaskPage } from "../fixtures/staged_page.ts";
import { twoJointPage } from "../fixtures/two_joint_page.ts";
import { launch, look, open, picture, rest, serve } from "./browser.ts";

let browser: Browser;
before(async () => {
  browser = await launch();
});
after(() => browser.close());

/** A small telephone. */
const SMALL = { viewport: { width: 375, height: 667 }, hasTouch: true, isMobile: true };

/** Least height of a control for a finger, in points. */
const FINGER = 32;

const PAGES: [string, () => PageData][] = [
  ["solved_task", solvedTaskPage],
  ["failed_task", failedTaskPage],
  ["carried", () => carriedPage({ plans: 2 })],
  ["compared", () => twoJointPage({ plans: 3, hasFailedPlan: true, treeNodes: 60 })],
  ["recording", recordedPage],
  ["scene", () => twoJointPage({ plans: 0, grasps: 0 })],
];

/** Visible elements that reach beyond the screen, or whose content is wider than they are and cannot be scrolled. */
function tooWide(page: Page): Promise<string[]> {
  return page.evaluate(() => {
    const width = document.documentElement.clientWidth;
    const told = (part: Element, why: string): string => `${why}: ${part.outerHTML.slice(0, 120)}`;
    const found = [...document.querySelectorAll<HTMLElement>(".page *")].flatMap((part) => {
      const { left, right, width: own } = part.getBoundingClientRect();
      if (own === 0 || !part.checkVisibility() || part.closest("svg, .said-over, .modes")) return [];
      return left < -0.5 || right > width + 0.5 ? [told(part, "beyond the screen")] : [];
    });
    const panel = document.querySelector<HTMLElement>(".panel");
    if (panel && panel.scrollWidth > panel.clientWidth) found.push(told(panel, "scrolls sideways"));
    if (document.documentElement.scrollWidth > width) found.push("the page scrolls sideways");
    return found;
  });
}

/** Visible controls that are too low for a finger. */
function tooSmall(page: Page): Promise<string[]> {
  return page.evaluate(
    (least) =>
      [...document.querySelectorAll<HTMLElement>("button, select, summary, label.switch, label.plan, label.slider")]
        .filter((part) => part.checkVisibility())
        .flatMap((part) => {
          const { width, height } = part.getBoundingClientRect();
          const isLow = height < least || (part.matches("button:not(.mode)") && width < least);
          return isLow ? [`${width} × ${height}: ${part.outerHTML.slice(0, 120)}`] : [];
        }),
    FINGER,
  );
}

for (const [name, data] of PAGES) {
  test(`on a small telephone nothing of the page ${name} is cut off, and every control fits a finger`, async () => {
    const server = await serve(data());
    const { page, complaints } = await open(browser, server.address, SMALL);
    try {
      assert.deepEqual(await tooWide(page), []);
      await picture(page, `narrow_${name}`);
      await page.getByRole("button", { name: "Settings" }).tap();
      const panel = page.getByRole("complementary", { name: "Settings" });
      await panel.waitFor();
      // Every section can be scrolled to and opened.
      const sections = panel.locator("details.section");
      for (let index = 0; index < (await sections.count()); index += 1) {
        const section = sections.nth(index);
        if ((await section.getAttribute("open")) === null) await section.locator("> summary").tap();
        await section.locator("> summary").scrollIntoViewIfNeeded();
      }
      for (const reason of await panel.locator("details.reason > summary").all()) await reason.tap();
      await rest(page);
      assert.deepEqual(await tooWide(page), []);
      assert.deepEqual(await tooSmall(page), []);
      const box = (await panel.boundingBox())!;
      const dock = page.getByRole("region", { name: "Time line" });
      const under = (await dock.isVisible()) ? (await dock.boundingBox())!.y : 667;
      const title = (await page.getByRole("banner").boundingBox())!;
      assert.ok(box.y + box.height <= under, "the panel covers the time line");
      assert.ok(box.y >= title.y + title.height + 100, "the panel leaves no room for the scene");
      await picture(page, `narrow_${name}_settings`);
      assert.deepEqual(complaints, []);
    } finally {
      await page.context().close();
      await server.close();
    }
  });
}

test("on a small telephone a stage and a grasp can be tapped, and the scene shows them above the panel", async () => {
  for (const data of [solvedTaskPage(), failedTaskPage()]) {
    const server = await serve(data);
    const { page, complaints } = await open(browser, server.address, SMALL);
    await page.getByRole("button", { name: "Settings" }).tap();
    const stages = page.locator(".stages");
    const isSolved = data.name === "staged";
    if (isSolved) {
      await stages.getByRole("button", { name: "Move home" }).tap();
      assert.equal(await look(page, "mode"), "carry");
      await stages.getByRole("button", { name: "Pick 'target'" }).tap();
    } else {
      await stages.getByText("Out of reach from every position").tap();
    }
    await stages.getByRole("button", { name: `Show grasp ${isSolved ? 0 : 4} in the scene` }).tap();
    await rest(page);
    assert.equal(await look(page, "grasp"), isSolved ? 0 : 4);
    const [tip, panel] = [
      (await page.getByRole("tooltip").boundingBox())!,
      (await page.getByRole("complementary").boundingBox())!,
    ];
    assert.ok(tip.y >= 0 && tip.y + tip.height <= panel.y && tip.x >= 0 && tip.x + tip.width <= 375, JSON.stringify(tip));
    await picture(page, `narrow_grasp_of_${data.name}`);
    assert.deepEqual(complaints, []);
    await page.context().close();
    await server.close();
  }
});
