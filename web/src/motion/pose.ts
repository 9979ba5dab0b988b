import type { Point, Pose } from "../data/page_data.ts";

/** Pose of a frame in itself. */
export const IDENTITY: Pose = [0, 0, 0, 0, 0, 0, 1];

/** `a_from_c = compose(a_from_b, b_from_c)`. Rotations must be unit quaternions. */
export function compose(a: Pose, b: Pose): Pose {
  const [x, y, z] = transformed(a, [b[0], b[1], b[2]]);
  const [ax, ay, az, aw] = [a[3], a[4], a[5], a[6]];
  const [bx, by, bz, bw] = [b[3], b[4], b[5], b[6]];
  return [
    x,
    y,
    z,
    aw * bx + ax * bw + ay * bz - az * by,
    aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw,
    aw * bw - ax * bx - ay * by - az * bz,
  ];
}

/** `b_from_a` of `a_from_b`: `compose(a, inverse(a))` = identity. */
export function inverse(a: Pose): Pose {
  const turn: Pose = [0, 0, 0, -a[3], -a[4], -a[5], a[6]];
  const [x, y, z] = transformed(turn, [-a[0], -a[1], -a[2]]);
  return [x, y, z, turn[3], turn[4], turn[5], turn[6]];
}

/** Converts a point from the source frame to the target frame. */
export function transformed(a: Pose, [x, y, z]: Point): Point {
  const [, , , qx, qy, qz, qw] = a;
  // v + 2 w (u × v) + 2 u × (u × v), where u is the vector component.
  const tx = 2 * (qy * z - qz * y);
  const ty = 2 * (qz * x - qx * z);
  const tz = 2 * (qx * y - qy * x);
  return [
    a[0] + x + qw * tx + qy * tz - qz * ty,
    a[1] + y + qw * ty + qz * tx - qx * tz,
    a[2] + z + qw * tz + qx * ty - qy * tx,
  ];
}

/** Rotation about a unit axis by an angle in radians. */
export function rotation([x, y, z]: Point, angle: number): Pose {
  const sine = Math.sin(angle / 2);
  return [0, 0, 0, x * sine, y * sine, z * sine, Math.cos(angle / 2)];
}

/** Translation along an axis by a length in metres. */
export function translation([x, y, z]: Point, length: number): Pose {
  return [x * length, y * length, z * length, 0, 0, 0, 1];
}

/** Angle between the orientations of two poses, in radians, 0 to π. */
export function angleBetween(a: Pose, b: Pose): number {
  const turn = compose(inverse(a), b);
  return 2 * Math.atan2(Math.hypot(turn[3], turn[4], turn[5]), Math.abs(turn[6]));
}

/** Distance between the origins of two frames. */
export function distanceBetween(a: Pose, b: Pose): number {
  return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}
