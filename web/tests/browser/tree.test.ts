import assert from "node:assert/strict";
import { test } from "node:test";
import type { Page } from "playwright-core";
import { twoJointPage } from "../fixtures/two_joint_page.ts";
import { launch, look, open, picture, rest, serve } from "./browser.ts";

const NODES = 100_000;
const WATCHED_MS = 3000;

test("a search of 10⁵ nodes is one draw call and grows with its slider", async () => {
  const server = await serve(twoJointPage({ treeNodes: NODES }));
  const browser = await launch();
  try {
    const { page, complaints } = await open(browser, server.address, { viewport: { width: 800, height: 600 } });
    console.log(`loading: ${(await look(page, "loadMs")).toFixed(0)} ms from the address to the first frame`);
    const bare = await watched(page);
    const [calls, nodes] = [await afterKey(page, "t"), await look(page, "treeNodes")];
    const without = await afterKey(page, "t");
    assert.deepEqual([calls, nodes], [without + 1, NODES]);
    await page.keyboard.press("t");
    const withTree = await watched(page);
    const words = ({ rate, script_ms }: Watched): string => `${rate.toFixed(1)} frames a second, script ${script_ms.toFixed(2)} ms a frame`;
    console.log(`without tree: ${words(bare)}\nwith ${NODES} nodes: ${words(withTree)}`);
    await page.getByRole("slider", { name: "Nodes of the search tree" }).fill("5000");
    await rest(page);
    assert.equal(await look(page, "treeNodes"), 5000);
    await picture(page, "tree");
    await page.getByRole("button", { name: "Let the tree grow" }).click();
    await page.waitForFunction(() => (window.cranny?.treeNodes ?? 0) > 6000);
    await page.getByRole("button", { name: "Stop growing" }).click();
    assert.deepEqual(complaints, []);
  } finally {
    await browser.close();
    await server.close();
  }
});

/** Draw calls of the frame that follows a key. */
async function afterKey(page: Page, key: string): Promise<number> {
  await page.keyboard.press(key);
  await rest(page);
  return look(page, "drawCalls");
}

interface Watched {
  rate: number;
  script_ms: number;
}

/** Plays slowly for a while and counts. */
async function watched(page: Page): Promise<Watched> {
  await page.getByRole("combobox", { name: "Speed" }).selectOption("0.1");
  await page.keyboard.press("Home");
  await page.keyboard.press(" ");
  const found = await page.evaluate(async (watched_ms) => {
    const door = window.cranny!;
    const [first, begin_ms] = [door.frames, performance.now()];
    const scripts: number[] = [];
    while (performance.now() - begin_ms < watched_ms) {
      await new Promise(requestAnimationFrame);
      scripts.push(door.frameScriptMs);
    }
    const middle = scripts.sort((a, b) => a - b)[scripts.length >> 1];
    return { rate: ((door.frames - first) / (performance.now() - begin_ms)) * 1000, script_ms: middle };
  }, WATCHED_MS);
  await page.keyboard.press(" ");
  await rest(page);
  return found;
}
