/**
 * What a page is told: one JSON document, written by the Rust crate `cranny-view` and read here.
 *
 * Lengths in metres, angles in radians, times in seconds, z up, everything in the planning frame unless it says
 * otherwise. A pose is `[x, y, z, qx, qy, qz, qw]`, target-from-source. Long rows of numbers are base64 of
 * little-endian values, row by row.
 */

/** Base64 of little-endian 32-bit floats. */
export type Floats32 = string;
/** Base64 of little-endian 64-bit floats. */
export type Floats64 = string;
/** Base64 of little-endian unsigned 32-bit integers. */
export type Unsigned32 = string;

export type Pose = [number, number, number, number, number, number, number];
export type Point = [number, number, number];

export interface PageData {
  format: "cranny-page/1";
  /** The id of the scenario, or what a recording is of. */
  name: string;
  /** Without links in a page of a recording. */
  robot: Robot;
  materials: Material[];
  meshes: Mesh[];
  /** What is seen; links first, so that node i < links.length is link i. Parents before children. */
  nodes: Node[];
  /** What is checked for collision, as surfaces: same form, same meshes and materials; a parent is one of `nodes`. */
  collision_shapes: Node[];
  /** The outer spheres of each link, in the frame of the link: rows x, y, z, radius. */
  link_spheres: Floats32[];
  world_from_floor: Pose | null;
  /** Where the base may be placed: x and y of its two translational joints, if it has them. */
  floor_area: { low: [number, number]; high: [number, number] } | null;
  /** Where something can be put down. */
  places: Place[];
  /** The grasps of the scenario, all of them. */
  grasps: Grasp[];
  plans: Plan[];
  /** What moved where, of a page that shows that alone. */
  recording?: Recording;
  /** Whether the server behind this page answers `POST verdict`. False in a page that is one file. */
  is_live: boolean;
  /** The number of this page, where the server may show another in its place. */
  feed?: number;
}

export interface Robot {
  links: { name: string; parent: number | null }[];
  joints: Joint[];
  /** The link whose frame is the gripper frame. */
  tip: number;
  /** Values of the variable joints where the scenario starts. */
  start: number[];
}

/** How a link hangs on its parent. One for each link but the root. */
export interface Joint {
  name: string;
  child: number;
  /** The pose of the child at the value 0. */
  parent_from_child: Pose;
  kind: "fixed" | "revolute" | "prismatic";
  /** In the frame of the child: `parent_from_child · motion along or about the axis by the value`. */
  axis: Point;
  /** Value = offset + factor × q[variable]; variable null: value = offset. */
  variable: number | null;
  factor: number;
  offset: number;
  /** Of the variable (null: unbounded). */
  lower: number | null;
  upper: number | null;
  /** Of a finger: how far its joint goes while the hand closes from open, where it stands at 0, to closed. */
  stroke?: number;
}

export interface Material {
  name: string;
  /** sRGB, 0 to 1. */
  colour: [number, number, number];
  opacity: number;
  metallic: number;
  roughness: number;
}

export interface Mesh {
  name: string;
  /** `colours`, if there: linear red, green, blue per corner, which the material's colour is multiplied by. */
  pieces: {
    material: number;
    positions: Floats32;
    normals: Floats32;
    colours?: Floats32;
    triangles: Unsigned32;
  }[];
}

export interface Node {
  name: string;
  parent: number | null;
  parent_from_node: Pose;
  mesh: number | null;
  role: "link" | "obstacle" | "target";
}

export interface Place {
  name: string;
  /** Of the middle of a rectangle, z upwards; else of the target's first part. */
  world_from_place: Pose;
  /** Along the x and y of the rectangle. */
  size_m?: [number, number];
}

export interface Grasp {
  index: number;
  world_from_gripper: Pose;
  score: number | null;
  /** Of the fingers' opening. */
  width_m: number | null;
  /** Factor by which gravity may grow before a pad slips. */
  load: number | null;
  /** What is known of inverse kinematics there. */
  ik: "solved" | "hand-collides" | "out-of-reach" | "no-solution" | "unknown" | string;
}

export interface Plan {
  name: string;
  planner: string;
  /** How the search ended, in words; empty for bare way points. */
  outcome: string;
  /** One line: what `verify` says of it. */
  verdict: string;
  is_valid: boolean;
  /** The row is empty if there is no path. */
  times_s: Floats64;
  /** One row of the robot's variables per instant. */
  configurations: Floats64;
  waypoint_times_s: Floats64;
  /** Whether the robot's limits give the path its time; else it has none, and its length passes at 1 a second. */
  is_timed: boolean;
  /** Sum over the edges of the plain norm of what q changes by, metres and radians alike. */
  path_length: number;
  /** What becomes of each object that the plan carries away, one after the other. */
  carries: Carry[];
  /** The scenario's grasp that the path ends at. */
  grasp: number | null;
  clearance: Clearance | null;
  /** What blocked each grasp, if the plan says so: one row per grasp. */
  blocked: { grasp: number; reason: string }[];
  /** Whole numbers by reason, as the plan file counts them. */
  blocked_counts: { reason: string; count: number }[];
  search_tree: SearchTree | null;
}

/** The object stands, the hand closes on it, and from then on it goes with the hand. */
export interface Carry {
  /** What it is called. */
  object: string;
  /** The robot's variables while the hand closes. */
  grasp: number[];
  /** How far it has closed then, from 0, open, to 1. */
  closing: number;
  /** The robot's variables where the hand opens again, of an object that is put down. */
  placed?: number[];
  /** What the robot does, one after the other; where the object comes into the hand, or leaves it, it stands, and the
   * hand moves evenly. */
  modes: Mode[];
}

export interface Mode {
  name: string;
  /** Whether an object is in the closed hand. */
  holds: boolean;
  /** Whether it may touch what carries it. */
  touches: boolean;
  /** Whether the hand has let one go before. */
  leaves: boolean;
  /** Index of the segment of the plan. */
  segment: number;
  from_s: number;
  until_s: number;
}

/** Bodies and where they go, whatever moved them. */
export interface Recording {
  times_s: Floats64;
  /** Of each node that moves its pose at each instant, row by row. */
  tracks: { node: number; poses: Floats64 }[];
}

/**
 * Least distance between the robot and anything else, or between two of its links, at instants of the path;
 * negative for how deep they overlap.
 */
export interface Clearance {
  times_s: Floats64;
  distances_m: Floats64;
  /** The same between the robot, with what it holds, and the world, and between its own links; at least 0, infinite
   * where there is no such pair. */
  world_m: Floats64;
  own_m: Floats64;
  /** Indices into `pairs`, one per instant. */
  closest: Unsigned32;
  pairs: { first: string; second: string }[];
  /** Rows ax, ay, az, bx, by, bz: the closest points at each instant. */
  points: Floats32;
}

/** The nodes of a search in the order in which they were added. */
export interface SearchTree {
  /** Where the gripper frame is: rows x, y, z. */
  positions: Floats32;
  /** The parent of each node by index; its own index for a root. */
  parents: Unsigned32;
  /** The tree of each node; 0: from the start. */
  trees: Unsigned32;
}

/** What a plan does, by index and step: what is in the hand and where everything else stands is as it is then. */
export interface During {
  plan: number;
  segment: number;
}

/** Body of `POST verdict`. */
export interface VerdictQuestion {
  q: number[];
  /** Left out as long as nothing has moved, and where the robot was posed by hand. */
  during?: During;
}

/** Its answer; 400 with `{ error: string }` for a malformed question. */
export interface Verdict {
  is_free: boolean;
  /** Signed: negative is depth, as far as it is known. */
  clearance_m: number | null;
  /** Names of what touches, empty if free. */
  contacts: { first: string; second: string }[];
  /** Gripper frame, by the server's forward kinematics. */
  world_from_gripper: Pose;
}
