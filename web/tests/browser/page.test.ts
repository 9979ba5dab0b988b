import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import type { Browser } from "playwright-core";
import { Kinematics } from "../../src/motion/kinematics.ts";
import type { PageData, Verdict } from "../../src/data/page_data.ts";
import { angleBetween, distanceBetween } from "../../src/motion/pose.ts";
import { ROBOT, twoJointPage } from "../fixtures/two_joint_page.ts";
import { launch, look, type Opened, open, picture, rest, serve } from "./browser.ts";
import { difference } from "./pixels.ts";

let browser: Browser;
before(async () => {
  browser = await launch();
});
after(() => browser.close());

/** Area that no panel covers. */
const SCENE = { x: 0, y: 60, width: 620, height: 420 };

/** Opens a page, runs `body` on it, and requires a console without complaints. */
async function withPage(
  data: PageData,
  body: (opened: Opened) => Promise<void>,
  {
    hash = "",
    judge,
    ...options
  }: { hash?: string; judge?: (q: number[]) => Verdict } & Parameters<typeof open>[2] = {},
): Promise<void> {
  const server = await serve(data, judge);
  const opened = await open(browser, server.address + hash, options);
  try {
    await body(opened);
    assert.deepEqual(opened.complaints, []);
  } finally {
    await opened.page.context().close();
    await server.close();
  }
}

test("the canvas shows robot and scene, and nothing of them when they are switched off", () =>
  withPage(twoJointPage(), async ({ page }) => {
    const scene = await page.screenshot();
    await picture(page, "two_joint");
    for (const key of ["v", "g", "p", "d"]) await page.keyboard.press(key);
    await rest(page);
    const share = await difference(browser, scene, await page.screenshot());
    assert.ok(share > 0.03, `only ${share} of the picture differs`);
  }));

test("a motion shows itself when the page opens, and who stops it finds it standing", () =>
  withPage(
    twoJointPage(),
    async ({ page }) => {
      assert.equal(await look(page, "time"), 2, "it did not play to its end");
      await page.keyboard.press("Home");
      await page.waitForFunction(() => location.hash === "#t=0");
      await page.reload();
      await page.waitForFunction(() => window.cranny !== undefined);
      await page.waitForTimeout(300);
      assert.deepEqual([await look(page, "isPlaying"), await look(page, "time")], [false, 0]);
    },
    { reducedMotion: "no-preference" },
  ));

test("whoever wants no motion has a page that opens still", () =>
  withPage(twoJointPage(), async ({ page }) => {
    await page.waitForTimeout(300);
    assert.deepEqual([await look(page, "isPlaying"), await look(page, "time")], [false, 0]);
  }));

test("a page that stands still draws nothing", () =>
  withPage(twoJointPage(), async ({ page }) => {
    const frames = await look(page, "frames");
    await page.waitForTimeout(500);
    assert.equal(await look(page, "frames"), frames);
  }));

test("play moves the robot and ends where the path ends", () =>
  withPage(twoJointPage(), async ({ page }) => {
    const start = await look(page, "worldFromGripper");
    await page.getByRole("button", { name: "Play" }).click();
    await page.waitForFunction(() => (window.cranny?.time ?? 0) > 0.3);
    assert.ok(distanceBetween(start, await look(page, "worldFromGripper")) > 0.02);
    await page.waitForFunction(() => window.cranny?.isPlaying === false);
    assert.equal(await look(page, "time"), 2);
  }));

test("at the end the gripper is at the grasp, and links are where kinematics have them on the way", () =>
  withPage(twoJointPage(), async ({ page }) => {
    await page.keyboard.press("End");
    const grasp = twoJointPage().grasps[0].world_from_gripper;
    const gripper = await look(page, "worldFromGripper");
    assert.ok(distanceBetween(gripper, grasp) < 1e-6 && angleBetween(gripper, grasp) < 1e-6);
    await page.getByRole("slider", { name: "Time along the path" }).fill("0.777");
    assert.equal(await look(page, "time"), 0.777);
    const expected = new Kinematics(ROBOT).worldFromGripper(await look(page, "q"));
    assert.ok(distanceBetween(await look(page, "worldFromGripper"), expected) < 1e-9);
  }));

test("a grasp that is pointed at says its score, its width and what IK knows", () => {
  const data = twoJointPage({ grasps: 5 });
  return withPage(data, async ({ page }) => {
    const { x, y } = await page.evaluate(() => window.cranny!.graspOnScreen(2));
    await page.mouse.move(x, y);
    await page.getByRole("tooltip").waitFor();
    const grasp = data.grasps[(await look(page, "grasp"))!];
    const said = await page.getByRole("tooltip").innerText();
    for (const part of [
      `Grasp ${grasp.index}`,
      grasp.score?.toFixed(2) ?? "—",
      "40.0 mm",
      "2.50",
      grasp.ik.replaceAll("-", " "),
    ]) {
      assert.ok(said.includes(part), `${said} lacks ${part}`);
    }
    await page.mouse.move(5, 300);
    await page.getByRole("tooltip").waitFor({ state: "hidden" });
    assert.equal(await look(page, "grasp"), null);
    // Selected by keys: the best, the next, the best again, and the one without a score.
    const seen: (number | null)[] = [];
    for (const key of [".", ".", ",", ","]) {
      await page.keyboard.press(key);
      seen.push(await look(page, "grasp"));
    }
    assert.deepEqual(seen, [0, 1, 0, 4]);
  });
});

/** Two hundred small grippers would hide the object and the hand. */
test("of many grasps the taken one and the best are shown, all when asked for", () => {
  const data = twoJointPage({ grasps: 200 });
  data.plans[0].grasp = 150;
  return withPage(data, async ({ page }) => {
    const panel = page.getByRole("complementary", { name: "Settings" });
    assert.equal(await look(page, "shownGrasps"), 11);
    assert.match(await panel.innerText(), /Grasps \(11 of 200\)/);
    await picture(page, "few_grasps");
    const few = await page.screenshot();
    await page.keyboard.press("e");
    await rest(page);
    assert.equal(await look(page, "shownGrasps"), 200);
    assert.match(await panel.innerText(), /Grasps \(200\)/);
    assert.ok((await difference(browser, few, await page.screenshot())) > 0.002);
  });
});

/** Earlier, the length of a path without acceleration limits was displayed as seconds. */
test("a path without time has a length and no seconds", () => {
  const data = twoJointPage({ plans: 2 });
  data.plans[0] = { ...data.plans[0], is_timed: false, path_length: 2 };
  return withPage(data, async ({ page }) => {
    const panel = page.getByRole("complementary", { name: "Settings" });
    const dock = page.getByRole("region", { name: "Time line" });
    assert.match(await panel.innerText(), /reach · length 2\.00[\s\S]*ik-rrt · 2\.50 s[\s\S]*nominal pace/);
    assert.match(await dock.innerText(), /0\.00 \/ 2\.00 long/);
    assert.doesNotMatch(await dock.innerText(), /\d s\b/);
    await picture(page, "without_time");
    await page.keyboard.press("]");
    assert.match(await dock.innerText(), /0\.00 \/ 2\.50 s/);
    assert.doesNotMatch(await panel.innerText(), /nominal pace/);
  });
});

test("a failed plan is shown with what blocked each grasp", () =>
  withPage(twoJointPage({ plans: 0, hasFailedPlan: true, grasps: 6 }), async ({ page }) => {
    assert.equal(await page.getByRole("region", { name: "Time line" }).count(), 0);
    const panel = page.getByRole("complementary", { name: "Settings" });
    assert.match(await panel.innerText(), /hand collides\s+2[\s\S]*out of reach\s+2[\s\S]*not connected\s+2/);
    const { x, y } = await page.evaluate(() => window.cranny!.graspOnScreen(4));
    await page.mouse.move(x, y);
    await page.getByRole("tooltip").waitFor();
    assert.match(await page.getByRole("tooltip").innerText(), /blocked\s+(hand collides|out of reach|not connected)/);
    const plain = await page.screenshot();
    await panel.getByText("out of reach").hover();
    await rest(page);
    assert.ok((await difference(browser, plain, await page.screenshot())) > 0);
    await picture(page, "failed_plan");
  }));

test("several plans play in step, and each can have the robot", () =>
  withPage(twoJointPage({ plans: 3 }), async ({ page }) => {
    /** Share of the scene covered by the other robots, without the paths of their grippers. */
    const others = async (time: string): Promise<number> => {
      await page.getByRole("slider", { name: "Time along the path" }).fill(time);
      await page.keyboard.press("p");
      await rest(page);
      const both = await page.screenshot({ clip: SCENE });
      await page.keyboard.press("a");
      await rest(page);
      const alone = await page.screenshot({ clip: SCENE });
      await page.keyboard.press("a");
      await page.keyboard.press("p");
      return difference(browser, both, alone);
    };
    assert.ok((await others("1")) > 0.005);
    // At the common start, the other robots do not cover the selected one.
    assert.equal(await others("0"), 0);
    await page.keyboard.press("]");
    assert.equal(await look(page, "plan"), 1);
    await page.getByText("two-joint-2").click();
    assert.equal(await look(page, "plan"), 2);
    await page.keyboard.press("End");
    assert.equal(await look(page, "time"), 3);
    await page.getByText("two-joint-0").click();
    // The shorter plan rests at its end.
    const grasp = twoJointPage().grasps[0].world_from_gripper;
    assert.ok(distanceBetween(await look(page, "worldFromGripper"), grasp) < 1e-6);
    await picture(page, "several_plans");
  }));

test("a press on the plot of the clearance goes there and names the closest pair", () =>
  withPage(twoJointPage(), async ({ page }) => {
    const plot = page.getByRole("img", { name: /Clearance over time; least 9.99 mm at 2.00 s/ });
    const [box, scrub] = [
      await plot.boundingBox(),
      await page.getByRole("slider", { name: "Time along" }).boundingBox(),
    ];
    assert.ok(box && scrub);
    // Centred on the slider's thumb.
    const thumb = 14;
    const x = scrub.x - box.x + thumb / 2 + 0.75 * (scrub.width - thumb);
    await plot.click({ position: { x, y: box.height / 2 } });
    assert.ok(Math.abs((await look(page, "time")) - 1.5) < 0.02);
    assert.match(await page.getByRole("region", { name: "Time line" }).innerText(), /58\.\d mm\s+gripper – table/);
  }));

test("a slider turns the verdict red, and Back to the path turns it back", () => {
  const judge = (q: number[]): Verdict => ({
    is_free: q[1] < 1,
    clearance_m: q[1] < 1 ? 0.02 : -0.003,
    contacts: q[1] < 1 ? [] : [{ first: "lower_arm", second: "table" }],
    world_from_gripper: new Kinematics(ROBOT).worldFromGripper(q),
  });
  return withPage(
    { ...twoJointPage(), is_live: true },
    async ({ page }) => {
      await page.getByText("Joints", { exact: true }).click();
      const verdict = page.getByRole("status").filter({ hasText: /Free|Contact/ });
      await page.locator('.verdict[data-kind="free"]').waitFor();
      const free = await page.screenshot();
      await page.getByRole("slider", { name: "shoulder" }).fill("1.5");
      await page.locator('.verdict[data-kind="contact"]').waitFor();
      assert.match(await verdict.innerText(), /Contact\s+lower arm – table/);
      await rest(page);
      assert.ok((await difference(browser, free, await page.screenshot())) > 0.01);
      await picture(page, "contact");
      await page.getByRole("button", { name: "Back to the path" }).click();
      await page.locator('.verdict[data-kind="free"]').waitFor();
      assert.deepEqual(await look(page, "q"), ROBOT.start);
    },
    { judge },
  );
});

test("a link brings back plan, time, layers and eye", () =>
  withPage(
    twoJointPage({ plans: 2 }),
    async ({ page }) => {
      assert.deepEqual([await look(page, "plan"), await look(page, "time")], [1, 1.25]);
      assert.ok(await page.getByRole("switch", { name: "Collision shapes" }).isChecked());
      assert.ok(!(await page.getByRole("switch", { name: "Grasps" }).isChecked()));
      await page.getByRole("button", { name: "Top view" }).click();
      await rest(page);
      await page.waitForFunction(() => location.hash.includes("eye="));
      const top = await page.screenshot();
      await page.reload();
      await page.waitForFunction(() => window.cranny !== undefined);
      await rest(page);
      assert.ok((await difference(browser, top, await page.screenshot())) < 0.01);
    },
    { hash: "#plan=1&t=1.25&show=collision&hide=grasps" },
  ));

test("keys show help, change the light, and leave sliders their arrows", () =>
  withPage(twoJointPage(), async ({ page }) => {
    await page.keyboard.press("?");
    await page.getByRole("dialog", { name: "Keys" }).waitFor();
    await picture(page, "help");
    await page.keyboard.press("Escape");
    await page.keyboard.press("m");
    assert.equal(await page.evaluate(() => document.documentElement.dataset["theme"]), "dark");
    await page.keyboard.press("ArrowRight");
    assert.ok(Math.abs((await look(page, "time")) - 0.05) < 1e-9);
    await page.getByText("Joints", { exact: true }).click();
    await page.getByRole("slider", { name: "elbow" }).focus();
    await page.keyboard.press("ArrowRight");
    assert.ok(Math.abs((await look(page, "time")) - 0.05) < 1e-9);
    assert.ok((await look(page, "q"))[2] > ROBOT.start[2]);
  }));

test("everything that can be pressed has a name", () =>
  withPage(twoJointPage({ plans: 2, hasFailedPlan: true, treeNodes: 50 }), async ({ page }) => {
    const nameless = await page.evaluate(() =>
      [...document.querySelectorAll<HTMLInputElement>("button, input, select, canvas, dialog")]
        .filter((part) => !(part.ariaLabel ?? part.labels?.[0]?.textContent ?? part.textContent)?.trim())
        .map((part) => part.outerHTML),
    );
    assert.deepEqual(nameless, []);
  }));

test("a screen of the size of a hand has room for all", () =>
  withPage(
    twoJointPage({ plans: 2, grasps: 5 }),
    async ({ page }) => {
      assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
      await page.getByRole("button", { name: "Play" }).tap();
      await page.waitForFunction(() => (window.cranny?.time ?? 0) > 0.1);
      await page.getByRole("button", { name: "Pause" }).tap();
      const { x, y } = await page.evaluate(() => window.cranny!.graspOnScreen(1));
      await page.touchscreen.tap(x + 4, y + 4);
      await page.getByRole("tooltip").waitFor();
      await picture(page, "hand");
      // The labels of the scale are next to the curve.
      const [plot, scrub] = [
        await page.getByRole("img", { name: /Clearance over time/ }).boundingBox(),
        await page.getByRole("slider", { name: "Time along" }).boundingBox(),
      ];
      assert.ok(plot && scrub);
      assert.ok(plot.x + plot.width - (scrub.x + scrub.width) >= 40);
      await page.getByRole("button", { name: "Settings" }).tap();
      await page.getByRole("complementary").getByText("Collision shapes").tap();
      assert.ok(await page.getByRole("switch", { name: "Collision shapes" }).isChecked());
      await picture(page, "hand_settings");
      const small = await page.evaluate(
        () =>
          [...document.querySelectorAll("button:not(.tab)")]
            .map((part) => part.getBoundingClientRect())
            .filter(({ width, height }) => width > 0 && Math.min(width, height) < 32).length,
      );
      assert.equal(small, 0);
    },
    { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true },
  ));

test("what is seen through is named, until nothing is", () => {
  const data = twoJointPage({ plans: 0 });
  const target = data.nodes.find(({ role }) => role === "target")!;
  const table = data.nodes.find(({ name }) => name === "table")!;
  // The crate encloses the target, and therefore hides it from every viewpoint.
  const [x, y, z, ...turn] = target.parent_from_node;
  const crate = { ...table, name: "crate", parent_from_node: [x, y, z + 0.02, ...turn] as typeof target.parent_from_node };
  return withPage({ ...data, nodes: [...data.nodes, crate] }, async ({ page }) => {
    const caption = page.getByRole("note");
    await caption.filter({ hasText: /seen through: .*crate/ }).waitFor();
    await page.keyboard.press("w");
    await caption.filter({ hasText: /^$/ }).waitFor({ state: "attached" });
  });
});

test("on a telephone the title lies beside the tools or below them, never under them", async () => {
  const name = "a_kitchen_with_a_name_that_is_long_enough_for_any_screen";
  for (const width of [360, 400, 530, 760]) {
    await withPage(
      { ...twoJointPage({ plans: 1 }), name },
      async ({ page }) => {
        const [title, tools] = [
          await page.getByRole("banner").boundingBox(),
          await page.getByRole("navigation", { name: "Tools" }).boundingBox(),
        ];
        assert.ok(title && tools);
        const isBeside = title.x + title.width <= tools.x;
        assert.ok(isBeside || title.y >= tools.y + tools.height, JSON.stringify({ width, title, tools }));
        assert.ok(title.x + title.width <= width && tools.x >= 0);
      },
      { viewport: { width, height: 780 }, hasTouch: true, isMobile: true },
    );
  }
});

test("a scenario without plan, grasps, floor and spheres can be looked at", () =>
  withPage(
    { ...twoJointPage({ plans: 0, grasps: 0 }), world_from_floor: null, floor_area: null, link_spheres: [] },
    async ({ page }) => {
      assert.deepEqual(await look(page, "q"), ROBOT.start);
      await page.keyboard.press(" ");
      assert.equal(await look(page, "isPlaying"), false);
    },
  ));

test("data of another format are refused in words", async () => {
  const server = await serve({ ...twoJointPage(), format: "cranny-page/9" as "cranny-page/1" });
  const page = await browser.newPage();
  await page.goto(server.address);
  assert.match(await page.getByRole("alert").innerText(), /cranny-page\/1, but these say "cranny-page\/9"/);
  await page.close();
  await server.close();
});
