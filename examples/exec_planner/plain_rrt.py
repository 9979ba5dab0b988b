"""A simple planner for `cranny bench run --planner "exec:python3 plain_rrt.py"`: standard library and NumPy only.

It is an example of the protocol (docs/exec_protocol.md), not of good planning:

1. Read the problem, the URDF, the triangles of the obstacles and the known goal configurations.
2. Cover every link with balls. A configuration is free if no ball touches a triangle, the floor or a ball of
   another link; pairs of links whose balls overlap at the start are ignored.
3. From each goal configuration, move the hand back along its approach direction. On this last stretch, hand and
   wrist may come close to the object; only the judge checks this. Under `paper`, whose goal tolerance is wide, the
   path ends before the stretch.
4. RRT-Connect (Kuffner and LaValle 2000) from the start to the retracted configuration.
5. Print the way points, close enough together for the `paper` criterion.
"""

import json
import sys
import time
import xml.etree.ElementTree as ElementTree

import numpy as np

FLOOR_M = -0.05
"""Height of the floor in the planning frame."""
CELL_M = 0.08
"""Greatest extent of a link along each axis that one ball covers."""
RETREAT_M = 0.12
"""Distance by which the hand moves back: slightly more than the length of the fingers."""
STEP = 0.1
"""Extension step of the trees, in the norm of q."""
CHECK_STEP = 0.05
"""Distance between checked configurations, in the same norm."""
GROUP = 12
"""Number of triangles in a group with a common bounding ball."""
PAPER_HEIGHT_M = 0.04
"""Height above which the `paper` criterion keeps the frames of the arm."""
PAPER_DISTANCE_M = 0.08
"""Distance from a grasp that the `paper` criterion accepts, with a reserve: d = 40 of at most 50."""
OUTPUT_STEP_M = 0.05
"""Greatest distance that a link frame moves between two way points; the `paper` criterion permits 0.1 m."""


def rotation(roll, pitch, yaw):
    """The rotation matrix of URDF's fixed-axis angles."""
    (cr, cp, cy), (sr, sp, sy) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    return np.array([
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ])


def origin(element):
    """The 4 x 4 pose of an element's <origin>."""
    pose = np.eye(4)
    tag = element.find("origin")
    if tag is not None:
        pose[:3, 3] = [float(x) for x in tag.get("xyz", "0 0 0").split()]
        pose[:3, :3] = rotation(*[float(x) for x in tag.get("rpy", "0 0 0").split()])
    return pose


def box_of(shape):
    """The box around one collision element: its pose in the link's frame, and its size."""
    geometry = shape.find("geometry")[0]
    if geometry.tag == "box":
        return origin(shape), np.array([float(x) for x in geometry.get("size").split()])
    if geometry.tag not in ("sphere", "cylinder", "capsule"):
        sys.exit(f"this example reads boxes, spheres, cylinders and capsules, not a <{geometry.tag}>")
    width = 2 * float(geometry.get("radius"))
    length = float(geometry.get("length", "0")) + (width if geometry.tag != "cylinder" else 0)
    return origin(shape), np.array([width, width, length])


def box_around(boxes):
    """The box around all boxes of a link, along its axes, which the `paper` criterion uses as the link's shape."""
    reaches = [(pose[:3, 3], np.abs(pose[:3, :3]) @ size / 2) for pose, size in boxes]
    lower = np.min([middle - reach for middle, reach in reaches], axis=0)
    upper = np.max([middle + reach for middle, reach in reaches], axis=0)
    pose = np.eye(4)
    pose[:3, 3] = (lower + upper) / 2
    return pose, upper - lower


def balls_of(pose, size):
    """Balls (centres, radius) that cover a box."""
    counts = np.ceil(size / CELL_M).astype(int)
    cell = size / counts
    grid = [(np.arange(n) + 0.5) * c - s / 2 for n, c, s in zip(counts, cell, size)]
    centres = np.stack(np.meshgrid(*grid, indexing="ij"), -1).reshape(-1, 3)
    return [(pose[:3, :3] @ centre + pose[:3, 3], np.linalg.norm(cell) / 2) for centre in centres]


class Robot:
    """Joints in the order of q, and the balls of every link."""

    def __init__(self, urdf, joints, tip, is_paper):
        root = ElementTree.parse(urdf).getroot()
        self.limits = np.array([[joint["lower"], joint["upper"]] for joint in joints])
        index = {joint["name"]: number for number, joint in enumerate(joints)}
        steps = {}
        for joint in root.iter("joint"):
            axis = joint.find("axis")
            axis = np.array([float(x) for x in axis.get("xyz").split()]) if axis is not None else None
            number = index.get(joint.get("name"))
            fixed = 0.0
            if number is None and joint.get("type") == "prismatic":
                # A finger, kept open.
                fixed = float(joint.find("limit").get("upper"))
            step = (joint.find("parent").get("link"), joint.get("type"), origin(joint), axis, number, fixed)
            steps[joint.find("child").get("link")] = step
        self.links = [link.get("name") for link in root.iter("link")]
        self.tip = self.links.index(tip)
        self.steps = steps
        self.order = []
        for link in self.links:
            self.visit(link)
        balls = []
        for link in root.iter("link"):
            boxes = [box_of(shape) for shape in link.findall("collision")]
            boxes = [box_around(boxes)] if is_paper and boxes else boxes
            number = self.links.index(link.get("name"))
            balls += [(number, *ball) for box in boxes for ball in balls_of(*box)]
        self.ball_link = np.array([link for link, _, _ in balls])
        self.ball_centre = np.array([centre for _, centre, _ in balls])
        self.ball_radius = np.array([radius for _, _, radius in balls])
        wrist = set(list(self.ancestors(tip))[:4]) | {link for link in self.links if "finger" in link}
        self.is_wrist = np.array([self.links[link] in wrist for link in self.ball_link])
        # The base, and links that move only with it, cannot move lower.
        moved = [any(self.steps[a][1] == "revolute" for a in self.ancestors(self.links[l])) for l in self.ball_link]
        self.may_touch_floor = np.array(moved)
        # Frames that the `paper` criterion keeps above a height: from the second joint of the arm on.
        second = [joint["name"] for joint in joints if joint["lower"] != joints[0]["lower"]][1]
        carried = root.find(f"joint[@name='{second}']/child").get("link")
        self.is_kept_high = np.array([is_paper and carried in self.ancestors(link) for link in self.links])

    def ancestors(self, link):
        """The link and its chain of parents, without the root."""
        while link in self.steps:
            yield link
            link = self.steps[link][0]

    def visit(self, link):
        """Appends a link to the order, parents first."""
        if link in self.order:
            return
        if link in self.steps:
            self.visit(self.steps[link][0])
        self.order.append(link)

    def frames(self, q):
        """The 4 x 4 poses of all links in the planning frame."""
        poses = {}
        for link in self.order:
            if link not in self.steps:
                poses[link] = np.eye(4)
                continue
            parent, kind, pose, axis, number, fixed = self.steps[link]
            value = fixed if number is None else q[number]
            motion = np.eye(4)
            if kind == "prismatic":
                motion[:3, 3] = axis * value
            elif kind == "revolute":
                k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
                motion[:3, :3] = np.eye(3) + np.sin(value) * k + (1 - np.cos(value)) * (k @ k)
            poses[link] = poses[parent] @ pose @ motion
        return np.stack([poses[link] for link in self.links])

    def balls(self, frames):
        """Centres of all balls."""
        frames = frames[self.ball_link]
        return np.einsum("nij,nj->ni", frames[:, :3, :3], self.ball_centre) + frames[:, :3, 3]


def read_triangles(path):
    """Corners (n, 3, 3) of the triangles of an OBJ file."""
    vertices, faces = [], []
    with open(path, encoding="utf-8") as file:
        for line in file:
            words = line.split()
            if words[:1] == ["v"]:
                vertices.append([float(x) for x in words[1:4]])
            elif words[:1] == ["f"]:
                corners = [int(word.split("/")[0]) - 1 for word in words[1:]]
                faces += [[corners[0], corners[k], corners[k + 1]] for k in range(1, len(corners) - 1)]
    return np.array(vertices)[np.array(faces)]


def distance_to_triangles(points, triangles):
    """Distance of each point from the triangle in the same row (Ericson 2005, §5.1.5, by cases)."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    normal = np.cross(b - a, c - a)
    square = np.maximum(np.einsum("ij,ij->i", normal, normal), 1e-300)
    height = np.einsum("ij,ij->i", points - a, normal)
    foot = points - normal * (height / square)[:, None]
    inside = np.ones(len(points), bool)
    nearest = np.full(len(points), np.inf)
    for p, r in ((a, b), (b, c), (c, a)):
        edge = r - p
        inside &= np.einsum("ij,ij->i", np.cross(edge, foot - p), normal) >= 0
        t = np.einsum("ij,ij->i", points - p, edge) / np.maximum(np.einsum("ij,ij->i", edge, edge), 1e-300)
        on_edge = p + edge * np.clip(t, 0, 1)[:, None]
        nearest = np.minimum(nearest, np.linalg.norm(points - on_edge, axis=1))
    return np.where(inside, np.abs(height) / np.sqrt(square), nearest)


class Checker:
    """Conservative collision check of configurations."""

    def __init__(self, robot, triangles, start):
        self.robot, self.triangles = robot, triangles
        # Consecutive triangles are usually close together: each group gets a bounding ball.
        self.groups = [np.arange(i, min(i + GROUP, len(triangles))) for i in range(0, len(triangles), GROUP)]
        corners = [triangles[group].reshape(-1, 3) for group in self.groups]
        self.middles = np.array([(c.min(axis=0) + c.max(axis=0)) / 2 for c in corners])
        self.reaches = np.array(
            [np.linalg.norm(c - m, axis=1).max() for c, m in zip(corners, self.middles)])
        first, second = np.triu_indices(len(robot.ball_link), 1)
        other = robot.ball_link[first] != robot.ball_link[second]
        first, second = first[other], second[other]
        centres = robot.balls(robot.frames(start))
        gap = np.linalg.norm(centres[first] - centres[second], axis=1)
        touching = gap < robot.ball_radius[first] + robot.ball_radius[second] + 0.01
        pairs = robot.ball_link[first] * 1000 + robot.ball_link[second]
        kept = ~np.isin(pairs, pairs[touching])
        self.first, self.second = first[kept], second[kept]
        self.reach = robot.ball_radius[self.first] + robot.ball_radius[self.second]

    def is_free(self, q, wrist_too=True):
        robot = self.robot
        if np.any(q < robot.limits[:, 0]) or np.any(q > robot.limits[:, 1]):
            return False
        frames = robot.frames(q)
        centres = robot.balls(frames)
        if np.any((centres[:, 2] - robot.ball_radius < FLOOR_M) & robot.may_touch_floor):
            return False
        if np.any(frames[robot.is_kept_high, 2, 3] < PAPER_HEIGHT_M):
            return False
        if np.any(np.linalg.norm(centres[self.first] - centres[self.second], axis=1) < self.reach):
            return False
        gaps = np.linalg.norm(centres[:, None] - self.middles[None], axis=2) - self.reaches
        near = (gaps < robot.ball_radius[:, None]) & (wrist_too | ~robot.is_wrist)[:, None]
        for group in np.flatnonzero(near.any(axis=0)):
            balls, triangles = np.flatnonzero(near[:, group]), self.groups[group]
            pairs = np.repeat(balls, len(triangles)), np.tile(triangles, len(balls))
            distances = distance_to_triangles(centres[pairs[0]], self.triangles[pairs[1]])
            if np.any(distances < robot.ball_radius[pairs[0]]):
                return False
        return True

    def motion_is_free(self, a, b):
        count = max(1, int(np.ceil(np.linalg.norm(b - a) / CHECK_STEP)))
        return all(self.is_free(a + (b - a) * t) for t in np.linspace(0, 1, count + 1)[1:])


def retreat(robot, goal, length_m):
    """Configurations from `goal` back along the approach direction of the hand."""
    path, q = [goal], goal.copy()
    begin = robot.frames(goal)[robot.tip]
    for distance in np.arange(0.01, length_m + 1e-9, 0.01):
        wanted = begin[:3, 3] - begin[:3, 2] * distance
        for _ in range(5):
            tip = robot.frames(q)[robot.tip]
            turn = begin[:3, :3] @ tip[:3, :3].T
            twist = np.concatenate([wanted - tip[:3, 3], 0.5 * np.array(
                [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])])
            jacobian = np.empty((6, len(q)))
            for joint in range(len(q)):
                moved = q.copy()
                moved[joint] += 1e-6
                other = robot.frames(moved)[robot.tip]
                spin = other[:3, :3] @ tip[:3, :3].T
                jacobian[:3, joint] = (other[:3, 3] - tip[:3, 3]) / 1e-6
                jacobian[3:, joint] = np.array([spin[2, 1], spin[0, 2], spin[1, 0]]) / 1e-6
            q = q + jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + 1e-4 * np.eye(6), twist)
        q = np.clip(q, robot.limits[:, 0], robot.limits[:, 1])
        path.append(q)
    return path


def connect(checker, start, goal, random, deadline):
    """RRT-Connect: returns a path from start to goal, or None, and the number of iterations."""
    trees = [([start], [-1]), ([goal], [-1])]
    iterations = 0

    def extend(tree, target):
        nodes, parents = tree
        nearest = int(np.argmin(np.linalg.norm(np.array(nodes) - target, axis=1)))
        while True:
            way = target - nodes[nearest]
            length = np.linalg.norm(way)
            q = target if length <= STEP else nodes[nearest] + way * (STEP / length)
            if not checker.motion_is_free(nodes[nearest], q):
                return nearest, False
            nodes.append(q)
            parents.append(nearest)
            nearest = len(nodes) - 1
            if length <= STEP:
                return nearest, True

    def back(tree, node):
        path = []
        while node >= 0:
            path.append(tree[0][node])
            node = tree[1][node]
        return path

    if checker.motion_is_free(start, goal):
        return [start, goal], iterations
    while time.monotonic() < deadline:
        iterations += 1
        sample = random.uniform(checker.robot.limits[:, 0], checker.robot.limits[:, 1])
        grown, _ = extend(trees[0], sample)
        met, is_there = extend(trees[1], trees[0][0][grown])
        if is_there:
            halves = [back(trees[0], grown), back(trees[1], met)]
            # The trees are swapped after every iteration.
            first, second = halves if np.array_equal(halves[0][-1], start) else halves[::-1]
            return first[::-1] + second[1:], iterations
        trees.reverse()
    return None, iterations


def densified(robot, path):
    """The path with additional way points, so that no link frame moves far between two of them."""
    dense = [path[0]]
    for a, b in zip(path, path[1:]):
        parts = 1
        while True:
            between = [a + (b - a) * t for t in np.linspace(0, 1, parts + 1)]
            origins = [robot.frames(q)[:, :3, 3] for q in between]
            if all(np.linalg.norm(v - u, axis=1).max() <= OUTPUT_STEP_M for u, v in zip(origins, origins[1:])):
                break
            parts *= 2
        dense += between[1:]
    return dense


def main():
    begin = time.monotonic()
    problem = json.load(sys.stdin)
    deadline = begin + 0.9 * problem["time_limit_s"]
    random = np.random.default_rng(problem["seed"])
    is_paper = problem["criterion"] == "paper"
    robot = Robot(problem["files"]["urdf"], problem["joints"], problem["tip"], is_paper)
    start = np.array(problem["start"])
    if problem["goal_configuration"] is not None:
        goals = [np.array(problem["goal_configuration"])]
    else:
        with open(problem["files"]["ik"], encoding="utf-8") as file:
            goals = [np.array([float(x) for x in line.split(",")]) for line in file if line.strip()]
    checker = Checker(robot, read_triangles(problem["files"]["obstacles"]), start)

    iterations = 0
    for goal in (goals[index] for index in random.permutation(len(goals))):
        last_stretch = retreat(robot, goal, PAPER_DISTANCE_M if is_paper else RETREAT_M)
        if is_paper:
            last_stretch = last_stretch[-1:]
        if not checker.is_free(last_stretch[-1]) or not all(checker.is_free(q, False) for q in last_stretch):
            continue
        # Each goal gets a share of the time, and goals are tried as long as time remains.
        share = time.monotonic() + max(1.0, (deadline - time.monotonic()) / 4)
        path, tried = connect(checker, start, last_stretch[-1], random, min(deadline, share))
        iterations += tried
        if path is not None:
            path = densified(robot, path + last_stretch[::-1][1:])
            answer = {"outcome": "solved", "waypoints": [q.tolist() for q in path]}
            break
        if time.monotonic() >= deadline:
            answer = {"outcome": "budget-exhausted"}
            break
    else:
        answer = {"outcome": "budget-exhausted"}
    json.dump({**answer, "statistics": {"iterations": iterations, "goals_tried": len(goals)}}, sys.stdout)


main()
