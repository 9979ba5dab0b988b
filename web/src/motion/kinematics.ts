import type { Joint, Pose, Robot } from "../data/page_data.ts";
import { IDENTITY, compose, rotation, translation } from "./pose.ts";

/** One variable of a configuration, as a slider moves it. */
export interface Variable {
  name: string;
  kind: "revolute" | "prismatic";
  /** Limits in radians or metres, if bounded. */
  lower: number | null;
  upper: number | null;
}

/** Forward kinematics of a robot in 64 bits: its gripper frame agrees with the program's to 1e-6. */
export class Kinematics {
  readonly robot: Robot;
  readonly variables: Variable[];
  private readonly jointOf: (Joint | undefined)[];
  private readonly order: number[];
  private readonly worldFromRoot: Pose;

  /** `worldFromRoot`: pose of the link without a parent. */
  constructor(robot: Robot, worldFromRoot: Pose = IDENTITY) {
    this.robot = robot;
    this.worldFromRoot = worldFromRoot;
    const joints = new Map(robot.joints.map((joint) => [joint.child, joint]));
    this.jointOf = robot.links.map((_, link) => joints.get(link));
    this.order = parentsFirst(robot);
    const moved = grouped(robot.joints, (joint) => joint.variable);
    this.variables = robot.start.map((_, index) => variable(moved.get(index) ?? [], index));
  }

  /** Poses of all links. `q` has one value per variable; `closing` of the hand is from 0 (open) to 1. */
  worldFromLinks(q: ArrayLike<number>, closing = 0): Pose[] {
    const poses: Pose[] = new Array(this.order.length);
    for (const link of this.order) {
      const parent = this.robot.links[link].parent;
      const joint = this.jointOf[link];
      const local = joint ? parentFromChild(joint, q, closing) : IDENTITY;
      poses[link] = compose(parent === null ? this.worldFromRoot : poses[parent], local);
    }
    return poses;
  }

  worldFromGripper(q: ArrayLike<number>): Pose {
    return this.worldFromLinks(q)[this.robot.tip];
  }
}

function parentFromChild(joint: Joint, q: ArrayLike<number>, closing: number): Pose {
  if (joint.kind === "fixed") return joint.parent_from_child;
  const moved = joint.variable === null ? 0 : joint.factor * q[joint.variable];
  const value = joint.offset + moved + (joint.stroke ?? 0) * closing;
  const motion = joint.kind === "revolute" ? rotation : translation;
  return compose(joint.parent_from_child, motion(joint.axis, value));
}

/** The joint that a variable moves directly, if there is one; else a joint that follows it by a factor. */
function variable(moved: Joint[], index: number): Variable {
  const joint = moved.find((each) => each.factor === 1 && each.offset === 0) ?? moved[0];
  if (!joint || joint.kind === "fixed") throw new Error(`no joint moves with variable ${index}`);
  return { name: joint.name, kind: joint.kind, lower: joint.lower, upper: joint.upper };
}

/** Items by a key, in their order. */
function grouped<Key, Item>(items: Item[], keyOf: (item: Item) => Key): Map<Key, Item[]> {
  const groups = new Map<Key, Item[]>();
  for (const item of items) {
    const known = groups.get(keyOf(item));
    if (known) known.push(item);
    else groups.set(keyOf(item), [item]);
  }
  return groups;
}

function parentsFirst(robot: Robot): number[] {
  const children = grouped([...robot.links.keys()], (link) => robot.links[link].parent);
  const order = [...(children.get(null) ?? [])];
  // The list grows while it is read.
  for (const link of order) for (const child of children.get(link) ?? []) order.push(child);
  if (order.length < robot.links.length) throw new Error("the links of the robot hang on each other in a circle");
  return order;
}
