import assert from "node:assert/strict";
import { test } from "node:test";
import { HEIGHT_RAD, STANDARD_VIEWS, framing } from "../../src/framing.ts";
import type { Point } from "../../src/data/page_data.ts";
import { isCrossed } from "../../src/views/see_through.ts";

const UNIT_BOX: { low: Point; high: Point } = { low: [0, 0, 0], high: [1, 1, 1] };

test("a line crosses a box or passes it", () => {
  assert.ok(isCrossed(UNIT_BOX, [-1, 0.5, 0.5], [2, 0.5, 0.5]));
  assert.ok(!isCrossed(UNIT_BOX, [-1, 1.5, 0.5], [2, 1.5, 0.5]));
  // The segment ends before the box.
  assert.ok(!isCrossed(UNIT_BOX, [-1, 0.5, 0.5], [-0.1, 0.5, 0.5]));
});

test("every standard view has all points in it and one at its edge", () => {
  const points: Point[] = Array.from({ length: 8 }, (_, i) => [(i & 1) * 2, ((i >> 1) & 1) - 3, i >> 2]);
  for (const view of STANDARD_VIEWS) {
    for (const [width, height] of [
      [1.5, 0.8],
      [0.4, 0.7],
    ]) {
      const { position, target } = framing(view, points, width, height);
      const back = unit(minus(position, target));
      const right = unit([-Math.sin((view.turn_deg * Math.PI) / 180), Math.cos((view.turn_deg * Math.PI) / 180), 0]);
      const up = cross(back, right);
      const slope = Math.tan(HEIGHT_RAD / 2);
      const filled = points.map((point) => {
        const away = minus(point, position);
        const depth = -dot(away, back);
        assert.ok(depth > 0);
        return Math.max(
          Math.abs(dot(away, right)) / (depth * slope * width),
          Math.abs(dot(away, up)) / (depth * slope * height),
        );
      });
      assert.ok(Math.abs(Math.max(...filled) - 0.93) < 1e-9, `${view.name}: ${Math.max(...filled)}`);
    }
  }
});

function minus(a: Point, b: Point): Point {
  return [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
}

function dot(a: Point, b: Point): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

function cross(a: Point, b: Point): Point {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

function unit(a: Point): Point {
  return a.map((value) => value / Math.sqrt(dot(a, a))) as Point;
}
