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
    this.jointOf = robot.links.map((_, link) => robot.joints.find((joint) => joint.child === link));
    this.order = parentsFirst(robot);
    this.variables = robot.start.map((_, index) => variable(robot.joints, index));
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
function variable(joints: Joint[], index: number): Variable {
  const moved = joints.filter((joint) => joint.variable === index);
  const joint = moved.find((each) => each.factor === 1 && each.offset === 0) ?? moved[0];
  if (!joint || joint.kind === "fixed") throw new Error(`no joint moves with variable ${index}`);
  return { name: joint.name, kind: joint.kind, lower: joint.lower, upper: joint.upper };
}

function parentsFirst(robot: Robot): number[] {
  const order: number[] = [];
  const isPlaced = robot.links.map(() => false);
  while (order.length < robot.links.length) {
    const before = order.length;
    robot.links.forEach((link, index) => {
      if (isPlaced[index] || (link.parent !== null && !isPlaced[link.parent])) return;
      isPlaced[index] = true;
      order.push(index);
    });
    if (order.length === before) throw new Error("the links of the robot hang on each other in a circle");
  }
  return order;
}
