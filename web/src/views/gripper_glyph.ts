import { BoxGeometry, type BufferGeometry, Quaternion, Vector3 } from "three";
import { mergeGeometries } from "three/addons/utils/BufferGeometryUtils.js";
import type { Point } from "../data/page_data.ts";

/** Half of the small gripper's opening, which is half the real one so that it does not hide the object. */
const HALF_OPENING_M = 0.022;

/** Distances from the gripper frame back to the palm and to the end of the stem. */
const PALM_M = -0.042;
const STEM_M = -0.07;

/** Fingers extend slightly past the gripper frame. */
const TIP_M = 0.006;

/** A small gripper as rods, in the gripper frame: it closes along y, and z points out of the palm. */
export const RODS: [Point, Point][] = [
  [
    [0, HALF_OPENING_M, TIP_M],
    [0, HALF_OPENING_M, PALM_M],
  ],
  [
    [0, -HALF_OPENING_M, TIP_M],
    [0, -HALF_OPENING_M, PALM_M],
  ],
  [
    [0, -HALF_OPENING_M, PALM_M],
    [0, HALF_OPENING_M, PALM_M],
  ],
  [
    [0, 0, PALM_M],
    [0, 0, STEM_M],
  ],
];

/** Geometry of the rods with a thickness. */
export function gripperGeometry(thickness_m: number): BufferGeometry {
  const rods = RODS.map(([from, to]) => {
    const [a, b] = [new Vector3(...from), new Vector3(...to)];
    const along = b.clone().sub(a);
    // Rods overlap at their ends, so that corners are closed.
    const rod = new BoxGeometry(thickness_m, thickness_m, along.length() + thickness_m);
    rod.applyQuaternion(new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), along.normalize()));
    const middle = a.add(b).multiplyScalar(0.5);
    return rod.translate(middle.x, middle.y, middle.z);
  });
  return mergeGeometries(rods);
}
