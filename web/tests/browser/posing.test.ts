import assert from "node:assert/strict";
import { statSync } from "node:fs";
import { after, before, test } from "node:test";
import type { Browser } from "playwright-core";
import type { PageData, Pose, Verdict } from "../../src/data/page_data.ts";
import { base64, floats32, unsigned32 } from "../../src/data/numbers.ts";
import { distanceBetween } from "../../src/motion/pose.ts";
import { searchTree, twoJointPage } from "../fixtures/two_joint_page.ts";
import { launch, look, open, picture, rest, serve } from "./browser.ts";

let browser: Browser;
before(async () => {
  browser = await launch();
});
after(() => browser.close());

test("the hand is dragged, the arm follows, and the posture is judged", async () => {
  const nowhere: Pose = [0, 0, 0, 0, 0, 0, 1];
  const free: Verdict = { is_free: true, clearance_m: 0.123, contacts: [], world_from_gripper: nowhere };
  const server = await serve({ ...twoJointPage(), is_live: true }, () => free);
  const { page, complaints } = await open(browser, `${server.address}#t=0`);
  await page.getByText("Joints", { exact: true }).click();
  await page.getByRole("button", { name: "Move the hand" }).click();
  await rest(page);
  await picture(page, "hand_drag");
  const [before, posture] = [await look(page, "worldFromGripper"), await look(page, "q")];
  const { x, y } = await page.evaluate(() => window.cranny!.gripperOnScreen());
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let step = 1; step <= 8; step += 1) await page.mouse.move(x - 6 * step, y - 4 * step);
  await page.mouse.up();
  await rest(page);
  const after = await look(page, "worldFromGripper");
  assert.ok(distanceBetween(before, after) > 0.02, `the gripper went ${distanceBetween(before, after)} m`);
  assert.notDeepEqual(await look(page, "q"), posture);
  await page.waitForFunction(() => window.cranny?.standing.kind === "known");
  assert.match(await page.locator(".verdict").innerText(), /Free, 123/);
  await page.getByRole("button", { name: "Back to the path" }).click();
  assert.deepEqual(await look(page, "q"), posture);
  assert.deepEqual(complaints, []);
  await page.context().close();
  await server.close();
});

test("a video of the motion comes as a file", async () => {
  const server = await serve(twoJointPage());
  const { page, complaints } = await open(browser, `${server.address}#t=1`);
  const waiting = page.waitForEvent("download");
  await page.keyboard.press("r");
  const film = await waiting;
  assert.match(film.suggestedFilename(), /^two-joint\.(webm|mp4)$/);
  assert.ok(statSync(await film.path()).size > 10_000);
  assert.equal(await look(page, "time"), 2);
  assert.deepEqual(complaints, []);
  await page.context().close();
  await server.close();
});

test("a search that is going on is seen growing, and what stands there stays", async () => {
  const data: PageData = { ...twoJointPage({ plans: 0 }), feed: 0 };
  const [first, all] = [40, 3000];
  let more = (): void => undefined;
  const wanted = new Promise<void>((resolve) => (more = resolve));
  const news = async (after: number): Promise<unknown> => {
    const told = (changes: number, nodes: number) => ({ changes, page: 0, poses: 0, q: null, tree: { search: 1, nodes } });
    if (after === 0) return told(1, first);
    if (after > 1) return new Promise(() => undefined);
    await wanted;
    return told(2, all);
  };
  const server = await serve(data, undefined, news, (after) => nodesAfter(all, after === 0 ? first : all, after));
  const { page, complaints } = await open(browser, server.address);
  await page.waitForFunction((nodes) => window.cranny?.treeNodes === nodes, first);
  assert.match((await page.locator(".searching").textContent()) ?? "", /^searching: 40 nodes$/);
  await page.keyboard.press("Escape");
  await rest(page);
  const stood = await look(page, "q");
  const calls = await look(page, "drawCalls");
  more();
  await page.waitForFunction((nodes) => window.cranny?.treeNodes === nodes, all);
  await rest(page);
  assert.equal(await look(page, "drawCalls"), calls);
  assert.deepEqual(await look(page, "q"), stood);
  await picture(page, "growing");
  await page.keyboard.press("t");
  await rest(page);
  assert.equal(await look(page, "treeNodes"), 0);
  assert.deepEqual(complaints, []);
  await page.context().close();
  await server.close();
});

/** The nodes of a tree between two counts, as the server returns them. */
function nodesAfter(all: number, until: number, after: number): unknown {
  const { positions, parents, trees } = searchTree(all);
  return {
    search: 1,
    from: after,
    positions: base64(floats32(positions).slice(3 * after, 3 * until)),
    parents: base64(unsigned32(parents).slice(after, until)),
    trees: base64(unsigned32(trees).slice(after, until)),
  };
}

test("a page that is fed shows postures as they come, and the next page from its begin", async () => {
  const data: PageData = { ...twoJointPage({ plans: 0 }), feed: 0 };
  const posed = [0.2, 0.5, -0.4];
  let turn = (): void => undefined;
  const turned = new Promise<void>((resolve) => (turn = resolve));
  const server = await serve(data, undefined, async (after) => {
    if (data.feed === 0 && after === 0) return { changes: 1, page: 0, poses: 1, q: posed, tree: null };
    if (data.feed === 1) return new Promise(() => undefined);
    await turned;
    Object.assign(data, twoJointPage(), { feed: 1 });
    return { changes: 2, page: 1, poses: 0, q: null, tree: null };
  });
  const { page, complaints } = await open(browser, server.address);
  await page.waitForFunction((q) => JSON.stringify(window.cranny?.q) === JSON.stringify(q), posed);
  assert.equal(await page.locator(".dock").isVisible(), false);
  turn();
  await page.locator(".dock").waitFor({ state: "visible" });
  await page.waitForFunction(() => window.cranny?.isIdle === true);
  assert.equal(await look(page, "time"), 0);
  assert.notDeepEqual(await look(page, "q"), posed);
  assert.deepEqual(complaints, []);
  await page.context().close();
  await server.close();
});
