import assert from "node:assert/strict";
import { test } from "node:test";
import { fromHash, toHash } from "../../src/data/view_link.ts";
import { INITIAL, type ViewState } from "../../src/data/view_state.ts";

test("the first view needs no words", () => {
  assert.equal(toHash(INITIAL), "");
  assert.deepEqual(fromHash(""), {});
});

test("a view comes back from its link", () => {
  const state: ViewState = {
    ...INITIAL,
    plan: 2,
    time_s: 1.25,
    speed: 0.5,
    isLooping: true,
    q: [0.1, -2, 0.333333],
    layers: { ...INITIAL.layers, tree: true, collision: true, grasps: false },
    ghosts: 7,
    treeNodes: 1234,
    graspColour: "ik",
    eye: { position: [1.5, -3, 0.75], target: [0, 0.1, 0.5] },
  };
  assert.deepEqual({ ...INITIAL, ...fromHash(`#${toHash(state)}`) }, state);
});

test("where something can play, a link says when", () => {
  assert.equal(toHash(INITIAL, true), "t=0");
  assert.equal(fromHash("#t=0").time_s, 0);
});

test("what a damaged link says wrongly is left out", () => {
  for (const hash of [
    "#t=NaN&plan=-1&ghosts=1e9&speed=0",
    "#eye=1,2,3&q=1,,2&by=colour",
    "#%%%&=&t=",
    "#nodes=-3&plan=1.5",
  ]) {
    assert.deepEqual(fromHash(hash), {}, hash);
  }
  assert.deepEqual(fromHash("#show=tree,nothing,__proto__").layers, { ...INITIAL.layers, tree: true });
});
