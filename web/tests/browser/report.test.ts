import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { pathToFileURL } from "node:url";
import { CRANNY, launch, PATIENCE_MS, SCREENSHOTS } from "./browser.ts";

/** The report is written by the program. */
const skip = CRANNY === "" ? "CRANNY_BIN names no program" : false;

/** Least height of a link or a fold for a finger, in points. */
const FINGER = 32;

test("the report of a campaign fits a small telephone and a desk", { skip }, async () => {
  const folder = mkdtempSync(join(tmpdir(), "cranny-report-"));
  const [results, report] = [join(folder, "results.db"), join(folder, "report.html")];
  const campaign = ["--scenarios", "021,035", "--planners", "reach,rrt-connect", "--runs", "2", "--time-limit", "5"];
  execFileSync(CRANNY, ["bench", "run", ...campaign, "-o", results, "--quiet"], { cwd: folder });
  execFileSync(CRANNY, ["bench", "report", results, "-o", report, "--quiet"], { cwd: folder });
  const browser = await launch();
  try {
    for (const [width, height] of [
      [375, 667],
      [1280, 800],
    ]) {
      const context = await browser.newContext({ viewport: { width, height }, isMobile: width < 400, hasTouch: width < 400 });
      const page = await context.newPage();
      page.setDefaultTimeout(PATIENCE_MS);
      await page.goto(pathToFileURL(report).href);
      await page.evaluate(() => document.querySelectorAll("details").forEach((fold) => (fold.open = true)));
      const wide = await page.evaluate(() => {
        const across = document.documentElement.clientWidth;
        const found = [...document.querySelectorAll("body *")].filter((part) => {
          // Tables and the contents scroll within themselves.
          if (part.closest(".scroll, nav ul, svg, script")) return part.matches(".scroll") && isBeyond(part, across);
          return isBeyond(part, across);
        });
        function isBeyond(part: Element, end: number): boolean {
          const { left, right, width: own } = part.getBoundingClientRect();
          return own > 0 && (left < -0.5 || right > end + 0.5);
        }
        const page = document.documentElement.scrollWidth > across ? ["the page scrolls sideways"] : [];
        return [...page, ...found.map((part) => part.outerHTML.slice(0, 120))];
      });
      assert.deepEqual(wide, [], `at ${width} points`);
      if (width < 400) {
        const low = await page.evaluate(
          (least) =>
            [...document.querySelectorAll("nav a, summary:not(td summary)")]
              .filter((part) => part.getBoundingClientRect().height < least)
              .map((part) => part.outerHTML.slice(0, 120)),
          FINGER,
        );
        assert.deepEqual(low, []);
        // Every table can be scrolled to its last column.
        for (const table of await page.locator(".scroll").all()) {
          const isAtEnd = await table.evaluate((part) => {
            part.scrollLeft = part.scrollWidth;
            return part.scrollLeft + part.clientWidth >= part.scrollWidth - 1;
          });
          assert.ok(isAtEnd);
        }
      }
      mkdirSync(SCREENSHOTS, { recursive: true });
      await page.screenshot({ path: join(SCREENSHOTS, `report_${width}.png`), fullPage: true });
      await context.close();
    }
  } finally {
    await browser.close();
    rmSync(folder, { recursive: true });
  }
});
