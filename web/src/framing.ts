import type { Point } from "./data/page_data.ts";
import type { Eye } from "./data/view_state.ts";

/** Vertical field of view, as of a portrait lens, for little distortion. */
export const HEIGHT_RAD = 0.42;

/** Share of the free half width or height that the content may fill. */
const FILLED = 0.93;

/** Direction of the camera from the viewed point, in degrees: rotation about z from x, and elevation. */
export interface StandardView {
  name: string;
  key: string;
  turn_deg: number;
  rise_deg: number;
}

/** The same views as in Cranny's pictures; exactly from above, rotation about z would leave "up" undefined. */
export const STANDARD_VIEWS: StandardView[] = [
  { name: "Three-quarter", key: "1", turn_deg: -75, rise_deg: 22 },
  { name: "Front", key: "2", turn_deg: 180, rise_deg: 14 },
  { name: "Side", key: "3", turn_deg: -90, rise_deg: 4 },
  { name: "Top", key: "4", turn_deg: 180, rise_deg: 89.9 },
];

const radians = (degrees: number): number => (degrees * Math.PI) / 180;
const dot = (a: Point, b: Point): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/**
 * Camera that looks from a direction, just far enough away for all `points` to be in the picture. `width` and
 * `height`: of the area free of panels, as shares of the height of the whole canvas.
 *
 * The position in the camera's frame follows from the four planes of its view pyramid, each of which touches one of
 * the points; the narrower pair determines the distance.
 */
export function framing(view: StandardView, points: Point[], width: number, height: number): Eye {
  const [turn, rise] = [radians(view.turn_deg), radians(view.rise_deg)];
  const back: Point = [Math.cos(rise) * Math.cos(turn), Math.cos(rise) * Math.sin(turn), Math.sin(rise)];
  const right: Point = [-Math.sin(turn), Math.cos(turn), 0];
  const up: Point = [
    back[1] * right[2] - back[2] * right[1],
    back[2] * right[0] - back[0] * right[2],
    back[0] * right[1] - back[1] * right[0],
  ];
  const slope = Math.tan(HEIGHT_RAD / 2) * FILLED;
  const all = points.length > 0 ? points : [[-1, -1, -1] as Point, [1, 1, 1] as Point];
  const farthest = (along: (p: Point) => number): number => all.reduce((far, p) => Math.max(far, along(p)), -Infinity);
  const between = (axis: Point, slope: number): [number, number] => {
    const one = farthest((p) => dot(p, axis) + slope * dot(p, back));
    const other = farthest((p) => -dot(p, axis) + slope * dot(p, back));
    return [(one + other) / (2 * slope), (one - other) / 2];
  };
  const [forWidth, x] = between(right, slope * width);
  const [forHeight, y] = between(up, slope * height);
  const distance = Math.max(forWidth, forHeight);
  const at = (along: number): Point => [0, 1, 2].map((i) => right[i] * x + up[i] * y + back[i] * along) as Point;
  const depth = (farthest((p) => dot(p, back)) - farthest((p) => -dot(p, back))) / 2;
  return { position: at(distance), target: at(depth) };
}
