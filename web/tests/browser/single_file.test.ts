import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { test } from "node:test";
import { gzipSync } from "node:zlib";
import { twoJointPage } from "../fixtures/two_joint_page.ts";
import { DIST, launch, look, open } from "./browser.ts";

const SLOT = '<script type="application/json" id="page-data"></script>';

test("the page as one file works from disk and loads nothing", async () => {
  const folder = mkdtempSync(join(tmpdir(), "cranny-page-"));
  const browser = await launch();
  try {
    const template = readFileSync(join(DIST, "single.html"), "utf8");
    assert.equal(template.split(SLOT).length, 2, "one place for the data");
    const packed = gzipSync(JSON.stringify(twoJointPage({ plans: 2 }))).toString("base64");
    const file = join(folder, "out.html");
    writeFileSync(file, template.replace(SLOT, SLOT.replace("></", `>${packed}</`)));
    const { page, complaints } = await open(browser, pathToFileURL(file).href);
    const loaded = await page.evaluate(() => performance.getEntriesByType("resource").map(({ name }) => name));
    assert.deepEqual(
      loaded.filter((name) => !name.startsWith("data:")),
      [],
    );
    await page.keyboard.press("End");
    assert.equal(await look(page, "time"), 2.5);
    await page.waitForFunction(() => location.hash === "#t=2.5");
    await page.keyboard.press("Home");
    await page.waitForFunction(() => location.hash === "#t=0");
    await page.getByText("Joints", { exact: true }).click();
    await page.getByRole("slider", { name: "elbow" }).fill("0.2");
    assert.equal((await look(page, "q"))[2], 0.2);
    assert.match(await page.locator(".verdict").innerText(), /need cranny view/);
    assert.deepEqual(complaints, []);
  } finally {
    await browser.close();
    rmSync(folder, { recursive: true });
  }
});
