/**
 * Data of a page: one JSON document, written by the Rust crate `cranny-view` and read here.
 *
 * Lengths in metres, angles in radians, times in seconds, z up; all in the planning frame unless stated otherwise.
 * A pose is `[x, y, z, qx, qy, qz, qw]`, target-from-source. Long rows of numbers are base64 of little-endian values,
 * row by row.
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
  /** Id of the scenario, or subject of a recording. */
  name: string;
  /** Has no links in a page that shows only a recording. */
  robot: Robot;
  materials: Material[];
  meshes: Mesh[];
  /** Visible bodies. The links come first, so that node i < links.length is link i; parents precede children. */
  nodes: Node[];
  /** Shapes for collision checking, in the same form, with the same meshes and materials; each parent is in `nodes`. */
  collision_shapes: Node[];
  /** The outer spheres of each link in its own frame: rows x, y, z, radius. */
  link_spheres: Floats32[];
  world_from_floor: Pose | null;
  /** Permitted base positions: limits of its two translational joints x and y, if it has them. */
  floor_area: { low: [number, number]; high: [number, number] } | null;
  /** Targets on which an object can be put down. */
  places: Place[];
  /** All grasps of the scenario. */
  grasps: Grasp[];
  plans: Plan[];
  /** Recorded motion of bodies, in a page that shows only a recording. */
  recording?: Recording;
  /** Whether the server behind this page answers `POST verdict`; false in a page that is one file. */
  is_live: boolean;
  /** Number of this page, if the server can replace it by another. */
  feed?: number;
}

export interface Robot {
  links: { name: string; parent: number | null }[];
  joints: Joint[];
  /** The link whose frame is the gripper frame. */
  tip: number;
  /** Values of the joint variables at the start of the scenario. */
  start: number[];
}

/** Connection of a link to its parent; one for each link except the root. */
export interface Joint {
  name: string;
  child: number;
  /** Pose of the child at the value 0. */
  parent_from_child: Pose;
  kind: "fixed" | "revolute" | "prismatic";
  /** In the frame of the child: `parent_from_child · motion along or about the axis by the value`. */
  axis: Point;
  /** Value = offset + factor × q[variable]; variable null: value = offset. */
  variable: number | null;
  factor: number;
  offset: number;
  /** Limit of the variable (null: unbounded). */
  lower: number | null;
  upper: number | null;
  /** For a finger: travel of its joint from the open hand, where its value is 0, to the closed hand. */
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
  /** `colours`, if present: linear red, green, blue per vertex, by which the material's colour is multiplied. */
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
  /** Frame at the centre of a rectangle, z up; without a rectangle, the frame of the target's first body. */
  world_from_place: Pose;
  /** Lengths along x and y of the rectangle. */
  size_m?: [number, number];
}

export interface Grasp {
  index: number;
  world_from_gripper: Pose;
  score: number | null;
  /** Opening between the fingers. */
  width_m: number | null;
  /** Factor by which gravity can grow before a pad slips. */
  load: number | null;
  /** Result of inverse kinematics for the grasp. */
  ik: "solved" | "hand-collides" | "out-of-reach" | "no-solution" | "unknown" | string;
}

export interface Plan {
  name: string;
  planner: string;
  /** Result of the search in words; empty for a path without a plan file. */
  outcome: string;
  /** Verdict of `verify` in one line. */
  verdict: string;
  is_valid: boolean;
  /** Empty if there is no path. */
  times_s: Floats64;
  /** One row of joint variables per instant. */
  configurations: Floats64;
  waypoint_times_s: Floats64;
  /** Whether the robot's limits determine the timing of the path; if not, it plays at a path length of 1 per second. */
  is_timed: boolean;
  /** Sum over the edges of the Euclidean norm of the change of q; metres and radians count alike. */
  path_length: number;
  /** The objects that the plan carries, one after the other. */
  carries: Carry[];
  /** Index of the scenario's grasp at which the path ends. */
  grasp: number | null;
  clearance: Clearance | null;
  /** Reason that blocked each grasp, if the plan states it: one row per grasp. */
  blocked: { grasp: number; reason: string }[];
  /** Number of grasps by reason, as in the plan file. */
  blocked_counts: { reason: string; count: number }[];
  /** Stages of the task; null for a plan without a list of stages. */
  task: Task | null;
  /** Effort of the search over all stages; null for bare way points. */
  search: { goals_tried: number; ik_attempts: number; planning_time_s: number } | null;
  search_tree: SearchTree | null;
}

/** A list of stages, each of which begins where the one before ends. The alternatives of a task without a path are the grasps
 * of its first pick. */
export interface Task {
  stages: TaskStage[];
  /** Index of the farthest stage at which an alternative failed; null if the task was solved, or if the plan file does not
   * state it. */
  failed_at: number | null;
  /** Number of grasps that were tried and that were not; null unless the plan file states the outcome of each grasp. */
  tried: number | null;
  not_tried: number | null;
}

export interface TaskStage {
  kind: "pick" | "move" | "place";
  /** Description in words. */
  name: string;
  /** "passed": an alternative led through it, but none through the whole task. */
  outcome: "done" | "passed" | "failed" | "not-reached" | "unknown";
  /** Start and end on the path; null without a path. */
  from_s: number | null;
  until_s: number | null;
  /** Index of the scenario's grasp that a pick takes, if it is one of them. */
  grasp: number | null;
  /** Proven lower bound along the stage. */
  clearance_m: number | null;
  /** Alternatives that failed at this stage, by reason, the most frequent first. */
  failed: FailedAlternatives[];
  /** Number of alternatives that had not failed after this stage; null unless the plan file states each outcome. */
  left: number | null;
}

export interface FailedAlternatives {
  /** Reason as in `blocked`. */
  reason: string;
  /** The same without the number of the stage. */
  because: string;
  count: number;
  /** Indices of the scenario's grasps among them, ascending. */
  grasps: number[];
}

/** One object that is carried: it stands, the hand closes on it, and from then on it moves with the hand. */
export interface Carry {
  /** Name of the object. */
  object: string;
  /** The robot's variables while the hand closes. */
  grasp: number[];
  /** Closed fraction of the fingers then, from 0 (open) to 1. */
  closing: number;
  /** The robot's variables where the hand opens again, if the object is put down. */
  placed?: number[];
  /** Consecutive stages of the motion. The robot stands between two of them while the hand closes or opens, at constant
   * speed. */
  modes: Mode[];
}

export interface Mode {
  name: string;
  /** Whether an object is in the closed hand. */
  holds: boolean;
  /** Whether the object may touch its support. */
  touches: boolean;
  /** Whether the hand has already released an object. */
  leaves: boolean;
  /** Index of the segment of the plan. */
  segment: number;
  from_s: number;
  until_s: number;
}

/** Recorded motion of bodies, from any source. */
export interface Recording {
  times_s: Floats64;
  /** The pose at each instant, row by row, of each node that moves. */
  tracks: { node: number; poses: Floats64 }[];
}

/** Least distance between the robot and anything else, or between two of its links, at instants of the path; negative:
 * penetration depth. */
export interface Clearance {
  times_s: Floats64;
  distances_m: Floats64;
  /** Least distance from the world to the robot with the object in its hand, and between the robot's own links; at
   * least 0, infinite if there is no such pair. */
  world_m: Floats64;
  own_m: Floats64;
  /** Indices into `pairs`, one per instant. */
  closest: Unsigned32;
  pairs: { first: string; second: string }[];
  /** The closest points at each instant: rows ax, ay, az, bx, by, bz. */
  points: Floats32;
}

/** The nodes of a search in the order in which they were added. */
export interface SearchTree {
  /** Positions of the gripper frame: rows x, y, z. */
  positions: Floats32;
  /** Index of each node's parent; a root's is its own index. */
  parents: Unsigned32;
  /** Tree of each node; 0: the tree from the start. */
  trees: Unsigned32;
}

/** Segment of a plan, which determines the object in the hand and the poses of all other objects. */
export interface During {
  plan: number;
  segment: number;
}

/** Body of `POST verdict`. */
export interface VerdictQuestion {
  q: number[];
  /** Absent until an object has moved, and if the robot was posed by hand. */
  during?: During;
}

/** Answer to the question; for a malformed one 400 with `{ error: string }`. */
export interface Verdict {
  is_free: boolean;
  /** Negative: penetration depth, if known. */
  clearance_m: number | null;
  /** Pairs in contact; empty if free. */
  contacts: { first: string; second: string }[];
  /** Gripper frame from the server's forward kinematics. */
  world_from_gripper: Pose;
}
