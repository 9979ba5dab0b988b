import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import type { Browser, Page } from "playwright-core";
import type { PageData } from "../../src/data/page_data.ts";
import { searchTree, twoJointPage } from "../fixtures/two_joint_page.ts";
import { CRANNY, launch, look, open, picture, rest, serve, view } from "./browser.ts";

const NODES = 100_000;
/** The times are printed and not judged: a short look in the plain run. */
const WATCHED_MS = process.env.CRANNY_LONG === undefined ? 1000 : 5000;

test("a search of 10⁵ nodes is one draw call and grows with its slider", async () => {
  const server = await serve(await pageWithTree());
  const browser = await launch();
  try {
    const { page, complaints } = await open(browser, server.address, { viewport: { width: 800, height: 400 } });
    console.log(`loading: ${(await look(page, "loadMs")).toFixed(0)} ms from the address to the first frame`);
    const bare = await watched(browser, page);
    const [calls, nodes] = [await afterSwitch(page), await look(page, "treeNodes")];
    const without = await afterSwitch(page);
    assert.deepEqual([calls, nodes], [without + 1, NODES]);
    await page.keyboard.press("t");
    await rest(page);
    const withTree = await watched(browser, page);
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

/** One of the program's scenarios with a plan, if the program is available, and a tree of exactly this size. */
async function pageWithTree(): Promise<PageData> {
  if (CRANNY === "") return twoJointPage({ treeNodes: NODES });
  const folder = mkdtempSync(join(tmpdir(), "cranny-tree-"));
  const plan = join(folder, "reach.plan.json");
  execFileSync(CRANNY, ["plan", "021", "-o", plan, "--quiet"]);
  const program = await view("021", plan);
  const data = (await (await fetch(`${program.address}page.json`)).json()) as PageData;
  await program.stop();
  rmSync(folder, { recursive: true });
  const plans = data.plans.map((each) => ({ ...each, search_tree: searchTree(NODES) }));
  return { ...data, plans, is_live: false };
}

/** Draw calls of a frame in which no object has moved, after the tree is switched on or off. */
async function afterSwitch(page: Page): Promise<number> {
  for (const key of ["t", "1", "1"]) {
    await page.keyboard.press(key);
    await rest(page);
  }
  return look(page, "drawCalls");
}

/** Cost of a frame. On a busy machine the rate falls, but processor times remain almost the same. */
interface Watched {
  rate: number;
  /** Wall-clock time of the page's own script; median over all frames. */
  script_ms: number;
  /** Processor times of the page's scripts and of rendering. */
  scriptProcessor_ms: number;
  drawProcessor_ms: number;
}

function words(watched: Watched): string {
  const [rate, clock, script, draw] = [
    watched.rate,
    watched.script_ms,
    watched.scriptProcessor_ms,
    watched.drawProcessor_ms,
  ].map((value) => value.toFixed(1));
  return `${rate} frames a second; a frame: script ${clock} ms (${script} ms of processor), drawing ${draw} ms of processor`;
}

/** Measures slow playback for a while. */
async function watched(browser: Browser, page: Page): Promise<Watched> {
  await page.getByRole("combobox", { name: "Speed" }).selectOption("0.1");
  await page.keyboard.press("Home");
  await page.keyboard.press(" ");
  const [ofPage, ofBrowser] = [await page.context().newCDPSession(page), await browser.newBrowserCDPSession()];
  await ofPage.send("Performance.enable", { timeDomain: "threadTicks" });
  const spent = async (): Promise<{ script_s: number; draw_s: number }> => {
    const { metrics } = await ofPage.send("Performance.getMetrics");
    const { processInfo } = await ofBrowser.send("SystemInfo.getProcessInfo");
    return {
      script_s: metrics.find(({ name }) => name === "ScriptDuration")?.value ?? 0,
      draw_s: processInfo.find(({ type }) => type === "GPU")?.cpuTime ?? 0,
    };
  };
  const before = await spent();
  const { frames, time_ms, script_ms } = await page.evaluate(async (watched_ms) => {
    const door = window.cranny!;
    const [first, begin_ms] = [door.frames, performance.now()];
    const scripts: number[] = [];
    while (performance.now() - begin_ms < watched_ms) {
      await new Promise(requestAnimationFrame);
      scripts.push(door.frameScriptMs);
    }
    const middle = scripts.sort((a, b) => a - b)[scripts.length >> 1];
    return { frames: door.frames - first, time_ms: performance.now() - begin_ms, script_ms: middle };
  }, WATCHED_MS);
  const after = await spent();
  await page.keyboard.press(" ");
  await rest(page);
  await Promise.all([ofPage.detach(), ofBrowser.detach()]);
  return {
    rate: (1000 * frames) / time_ms,
    script_ms,
    scriptProcessor_ms: (1000 * (after.script_s - before.script_s)) / frames,
    drawProcessor_ms: (1000 * (after.draw_s - before.draw_s)) / frames,
  };
}
