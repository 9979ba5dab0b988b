#!/usr/bin/env python3
"""Checks a certificate of a motion, `cranny-certificate/1`: see docs/certificate.md, whose inequalities the comments cite.

Whole numbers and fractions alone, from the standard library. It shares no code with the checker in Rust.
"""

import hashlib
import re
import sys
from fractions import Fraction
from math import isqrt

S = 96  # (1) Ends of intervals are whole multiples of 2^-96.
ONE = 1 << S
HALF = (ONE // 2, ONE // 2)
ZERO, UNIT = (0, 0), (ONE, ONE)
LARGEST = 10**6
MOST = {"joint": 256, "object": 1024, "solid": 1024, "depth": 128, "points": 16, "halvings": 96}
MOST_WORK = 20_000_000
SIZES = {"box": 3, "ball": 1, "capsule": 2, "cylinder": 2, "half": 0, "hull": 1, "mesh": 0}


NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)(e[+-]?[0-9]+)?", re.ASCII | re.IGNORECASE)
PLANE = re.compile(r"(-?[0-9]{1,5}),(-?[0-9]{1,5}),(-?[0-9]{1,5})", re.ASCII)


class Refused(Exception):
    """A line that does not hold."""


class Malformed(Exception):
    """A line that is not of the format."""


def unless(holds, reason):
    if not holds:
        raise Malformed(reason)


# (1) Intervals: pairs of whole numbers, rounded outwards.


def exact(x):
    n = Fraction(x) * ONE
    return (n.numerator // n.denominator, -(-n.numerator // n.denominator))


def add(a, b):
    return (a[0] + b[0], a[1] + b[1])


def neg(a):
    return (-a[1], -a[0])


def sub(a, b):
    return (a[0] - b[1], a[1] - b[0])


def mul(a, b):
    products = (a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1])
    return (min(products) >> S, -(-max(products) >> S))


def over(a, b):
    unless(b[0] > 0, "a division by zero")
    return (min(a[0] * ONE // b[0], a[0] * ONE // b[1]), max(-(-a[1] * ONE // b[0]), -(-a[1] * ONE // b[1])))


def mag(a):
    return (0 if a[0] <= 0 <= a[1] else min(abs(a[0]), abs(a[1])), max(abs(a[0]), abs(a[1])))


def root(a):
    low, high = isqrt(max(a[0], 0) << S), isqrt(max(a[1], 0) << S)
    return (low, high + 1)


def square(a):
    m = mag(a)
    return mul(m, m)


def total(values):
    low = high = 0
    for value in values:
        low, high = low + value[0], high + value[1]
    return (low, high)


def dot(a, b):
    return total(mul(x, y) for x, y in zip(a, b))


def cross(a, b):
    return [sub(mul(a[i - 2], b[i - 1]), mul(a[i - 1], b[i - 2])) for i in range(3)]


def length(a):
    return root(total(square(x) for x in a))


def plus(a, b):
    return [add(x, y) for x, y in zip(a, b)]


def minus(a):
    return [neg(x) for x in a]


def scaled(a, by):
    return [mul(x, by) for x in a]


def times(m, v):
    return [dot(row, v) for row in m]


def transposed(m):
    return [[m[j][i] for j in range(3)] for i in range(3)]


def product(a, b):
    columns = transposed(b)
    return [[dot(row, column) for column in columns] for row in a]


def machin(bits):
    """Returns 2^bits times pi, to a few units: 16 arctan(1/5) - 4 arctan(1/239), each an alternating series."""

    def arctan(n):
        result, power, k = 0, (1 << bits) // n, 0
        while power:
            result += (-power if k % 2 else power) // (2 * k + 1)
            power, k = power // (n * n), k + 1
        return result

    return 16 * arctan(5) - 4 * arctan(239)


# The error of the sum is far below 2^-104.
QUARTER = (machin(128) // 2 - (1 << 20)) >> 32, ((machin(128) // 2 + (1 << 20)) >> 32) + 1


def sin_cos(x):
    """(2) Encloses sine and cosine: k quarter turns and the rest r, whose series alternates."""
    k = round(Fraction(x[0] + x[1], 2 * QUARTER[0]))
    unless(abs(k) <= 1 << 20, "an angle that is too large")
    r = (x[0] - max(k * QUARTER[0], k * QUARTER[1]), x[1] - min(k * QUARTER[0], k * QUARTER[1]))
    unless(mag(r)[1] < ONE, "an angle that is too wide")
    values = []
    for first in (1, 0):
        term, value, n = (r if first else UNIT), ZERO, first
        while mag(term)[1] > 4:
            value = add(value, term)
            term = neg(over(mul(term, square(r)), exact((n + 1) * (n + 2))))
            n += 2
        rest = mag(term)[1]
        values.append((value[0] - rest, value[1] + rest))
    sine, cosine = values
    return [(sine, cosine), (cosine, neg(sine)), (neg(sine), neg(cosine)), (neg(cosine), sine)][k % 4]


# (3) Poses and links.


def number(word):
    unless(len(word) <= 32 and NUMBER.fullmatch(word), "a number that is none")
    x = float(word)
    unless(abs(x) <= LARGEST, "a number that is none, or too large")
    return Fraction(x)


def numbers(words, count):
    unless(len(words) == count, f"{count} numbers are expected")
    return [number(word) for word in words]


def index(word, below):
    unless(len(word) <= 9 and word.isascii() and word.isdigit() and int(word) < below, "an index out of range")
    return int(word)


def pose(words):
    """Returns rotation and translation of x y z qw qx qy qz; the quaternion is scaled to length 1."""
    x, y, z, w, a, b, c = numbers(words, 7)
    s = w * w + a * a + b * b + c * c
    unless(Fraction(1, 10**6) < s < 10**6, "a quaternion must have a length near 1")
    rows = [
        [1 - 2 * (b * b + c * c) / s, 2 * (a * b - c * w) / s, 2 * (a * c + b * w) / s],
        [2 * (a * b + c * w) / s, 1 - 2 * (a * a + c * c) / s, 2 * (b * c - a * w) / s],
        [2 * (a * c - b * w) / s, 2 * (b * c + a * w) / s, 1 - 2 * (a * a + b * b) / s],
    ]
    return [[exact(e) for e in row] for row in rows], [exact(e) for e in (x, y, z)]


def after(first, second):
    return product(first[0], second[0]), plus(first[1], times(first[0], second[1]))


IDENTITY = ([[UNIT, ZERO, ZERO], [ZERO, UNIT, ZERO], [ZERO, ZERO, UNIT]], [ZERO] * 3)


class Solid:
    """A solid with its pose in the object; points are whole multiples of 2^-96, to one unit."""

    def __init__(self, kind, placed, sizes):
        self.kind, self.pose, self.sizes = kind, placed, [exact(size) for size in sizes]
        self.inverse, self.points, self.faces = transposed(placed[0]), [], []

    def support(self, n, faces):
        """(4) Returns an upper bound of n·p over the solid, or these faces."""
        m = times(self.inverse, n)
        base, h = dot(n, self.pose[1])[1], self.sizes
        if self.kind == "box":
            return base + total(mul(mag(m[i]), h[i]) for i in range(3))[1]
        if self.kind == "ball":
            return base + mul(length(m), h[0])[1]
        if self.kind in ("capsule", "cylinder"):
            across = length(m if self.kind == "capsule" else m[:2])
            return base + add(mul(mag(m[2]), h[0]), mul(across, h[1]))[1]
        unless(self.kind in ("hull", "mesh"), "a half-space needs its own plane")
        points = self.points
        if faces != (0, len(self.faces)):
            points = [points[i] for i in {i for face in self.faces[faces[0] : faces[1]] for i in face}]
        middle = [(x[0] + x[1]) // 2 for x in m]
        a, b, c = middle
        far = max(a * p[0] + b * p[1] + c * p[2] for p in points)
        error = sum((m[i][1] - m[i][0] + 1) * self.largest[i] + abs(middle[i]) + 1 for i in range(3))
        base += ((far + error) >> S) + 1
        return base + (mul(length(m), h[0])[1] if self.kind == "hull" else 0)

    def finish(self):
        """Computes the box around the solid, in the frame of the object."""
        if self.kind in ("hull", "mesh"):
            unless(self.points and bool(self.faces) == (self.kind == "mesh"), "a solid without points or faces")
            self.largest = [max(abs(point[i]) for point in self.points) + 1 for i in range(3)]
        if self.kind != "half":
            axis = lambda i, sign: [(sign * ONE,) * 2 if j == i else ZERO for j in range(3)]
            whole = (0, len(self.faces))
            self.box = [[s * self.support(axis(i, s), whole) for i in range(3)] for s in (-1, 1)]


class Object:
    def __init__(self, name, is_body):
        self.name, self.is_body, self.solids = name, is_body, []
        self.parent, self.pose, self.motion, self.depth, self.lines = None, IDENTITY, None, 0, []

    def span(self, begin, end):
        return (begin, end, 0, len(self.solids[begin].faces) if end == begin + 1 else 0)

    def whole(self):
        return self.span(0, len(self.solids))

    def halves(self, span):
        begin, end, first, last = span
        if end > begin + 1:
            middle = begin + (end - begin) // 2
            return self.span(begin, middle), self.span(middle, end)
        unless(last > first + 1, "a part that cannot be halved")
        middle = first + (last - first) // 2
        return (begin, end, first, middle), (begin, end, middle, last)

    def has_whole_meshes(self, span):
        return span[1] > span[0] + 1 or span[3] - span[2] == len(self.solids[span[0]].faces)

    def support(self, span, n):
        faces = lambda solid: span[2:] if span[1] == span[0] + 1 else (0, len(solid.faces))
        return max(solid.support(n, faces(solid)) for solid in self.solids[span[0] : span[1]])

    def ball(self, span):
        boxes = [solid.box for solid in self.solids[span[0] : span[1]]]
        low = [min(box[0][i] for box in boxes) for i in range(3)]
        high = [max(box[1][i] for box in boxes) for i in range(3)]
        center = [(a + b) // 2 for a, b in zip(low, high)]
        half = [(max(c - a, b - c),) * 2 for a, b, c in zip(low, high, center)]
        return [(c, c) for c in center], length(half)


class Scene:
    """Robot, world and rules, read line by line."""

    def __init__(self, before):
        self.name, self.joints, self.objects, self.before, self.hash, self.paths = None, [], [], before, None, 0
        self.margin = self.start = self.tip = self.open = None
        self.pairs_apart, self.goals, self.exceptions, self.pairs = {}, [], [], []

    def line(self, words):
        kind, rest = words[0], words[1:]
        if self.objects and kind in ("v", "f"):
            self.objects[-1].lines.append(" ".join(words))
        if self.open and kind in ("v", "f") and self.open.kind in ("hull", "mesh"):
            if kind == "v":
                unless(not self.open.faces, "a vertex after a face")
                self.open.points.append([exact(x)[0] for x in numbers(rest, 3)])
            else:
                unless(self.open.kind == "mesh" and len(rest) == 3, "a face has three vertices")
                self.open.faces.append(tuple(index(word, len(self.open.points)) for word in rest))
            return
        self.close()
        has_place = self.margin is None and len(self.objects) < MOST["object"]
        if kind in SIZES:
            self.solid(kind, rest)
        elif kind == "body" and len(rest) == 1 and has_place:
            self.objects.append(Object(rest[0], True))
        elif kind == "link" and len(rest) >= 10 and has_place:
            self.link(*rest)
        else:
            self.rule(kind, rest)
            return
        self.objects[-1].lines.append(" ".join(words))

    def close(self):
        if self.open:
            self.open.finish()
            self.open = None

    def rule(self, kind, rest):
        """Reads a line that is neither an object nor a solid."""
        count, is_rule = len(rest), self.margin is not None
        if kind == "scene" and count == 1 and not self.name:
            self.name = rest[0]
        elif kind == "joint" and count == 3 and not self.objects and len(self.joints) < MOST["joint"]:
            self.joints.append((rest[0], number(rest[1]), number(rest[2])))
        elif kind == "margin" and not is_rule:
            (self.margin,) = numbers(rest, 1)
            unless(self.margin >= 0, "a margin is not negative")
        elif kind in ("keep", "skip") and is_rule and count == 3:
            pair = tuple(index(word, len(self.objects)) for word in rest[:2])
            unless(pair[0] < pair[1] and pair not in self.pairs_apart, "each pair once, the lower index first")
            self.pairs_apart[pair] = number(rest[2]) if kind == "keep" else None
            self.exceptions.append(" ".join([kind, *(self.objects[i].name for i in pair), rest[2]]))
        elif kind == "start" and self.start is None:
            self.start = numbers(rest, len(self.joints))
        elif kind == "tip" and is_rule and self.tip is None and count == 1:
            self.tip = index(rest[0], len(self.objects))
        elif kind == "goal" and is_rule and count == 8:
            self.goals.append(pose(rest[1:]))
        else:
            raise Malformed("a line of no known kind, or not at this place")

    def link(self, name, parent, *rest):
        link, links = Object(name, False), len(self.objects)
        unless(not any(known.is_body for known in self.objects), "links come before bodies")
        if parent != "-":
            link.parent = index(parent, links)
            link.depth = self.objects[link.parent].depth + 1
        unless(link.depth < MOST["depth"] and (link.parent is None) == (links == 0), "one root")
        link.pose = pose(rest[:7])
        if rest[7] in ("turn", "slide"):
            unless(len(rest) == 14, "a joint: INDEX FACTOR OFFSET AXIS")
            factor, offset, *axis = [exact(x) for x in numbers(rest[9:], 5)]
            long = length(axis)
            unless(long[0] * 1000 > ONE and long[1] < 1000 * ONE, "an axis must have a length near 1")
            unit = [over(x, long) for x in axis]
            link.motion = (rest[7] == "turn", index(rest[8], len(self.joints)), factor, offset, unit)
        else:
            unless(rest[7:] == ("fixed",), "a motion that is none")
        self.objects.append(link)

    def solid(self, kind, rest):
        unless(self.objects and self.margin is None and len(rest) == 7 + SIZES[kind], "a solid: POSE and sizes")
        sizes = numbers(rest[7:], SIZES[kind])
        unless(all(size > 0 or (kind == "hull" and size == 0) for size in sizes), "a size must be positive")
        owner = self.objects[-1]
        unless(kind != "half" or owner.is_body, "a link cannot be a half-space")
        unless(len(owner.solids) < MOST["solid"], "too many solids")
        self.open = Solid(kind, pose(rest[:7]), sizes)
        owner.solids.append(self.open)

    def chain(self, top, of):
        chain, at = [], None if self.objects[of].is_body else of
        while at is not None and at != top:
            chain.append(at)
            at = self.objects[at].parent
        return chain[::-1]

    def common(self, a, b):
        same = [x for x, y in zip(self.chain(None, a), self.chain(None, b)) if x == y]
        return same[-1] if same else None

    def finish(self, hash_):
        """Lists the pairs that must be proven, and what differs from the scene before."""
        self.close()
        self.hash = hash_
        if self.before:
            scene, end = self.before
            unless(self.start == end, "the scene does not start where the path before it ends")
            for sign, new, old in (("-", scene, self), ("+", self, scene)):
                lines = {tuple(known.lines) for known in old.objects}
                self.exceptions += [f"{sign} {known.name}" for known in new.objects if tuple(known.lines) not in lines]
            self.before = None
        unless(self.joints and self.start and self.goals and self.tip is not None, "a scene without start, tip or goal")
        unless(not self.objects[self.tip].is_body, "the tip is a link")
        for a, first in enumerate(self.objects):
            for b in range(a + 1, len(self.objects)) if first.solids and not first.is_body else ():
                top, distance = self.common(a, b), self.pairs_apart.get((a, b), self.margin)
                moves = any(self.objects[i].motion for end in (a, b) for i in self.chain(top, end))
                if self.objects[b].solids and moves and distance is not None:
                    self.pairs.append((a, b, distance))


def halves(curve):
    first, second = [curve[0]], [curve[-1]]
    while len(curve) > 1:
        curve = [[mul(add(x, y), HALF) for x, y in zip(a, b)] for a, b in zip(curve, curve[1:])]
        first.append(curve[0])
        second.append(curve[-1])
    return first, second[::-1]


def differences(points):
    return [[sub(y, x) for x, y in zip(a, b)] for a, b in zip(points, points[1:])]


class Moment:
    """(5) Joints in the middle of a piece, with bounds along it, and the pose of each link in its parent."""

    def __init__(self, scene, curve):
        degree, (left, right) = len(curve) - 1, halves(curve)
        most = lambda rows, factor: [max([factor * mag(row[j])[1] for row in rows], default=0) for j in range(len(curve[0]))]
        steps = differences(curve)
        self.rate = [(degree * x[0], degree * x[1]) for x in differences([left[-2], right[1]])[0]]
        self.fastest, self.bend = most(steps, degree), most(differences(steps), degree * (degree - 1))
        self.links = [self.local(link, right[0]) for link in scene.objects if not link.is_body]

    @staticmethod
    def local(link, q):
        """(3) Returns the pose of a link in its parent."""
        if not link.motion:
            return link.pose
        turns, joint, factor, offset, axis = link.motion
        value = add(mul(q[joint], factor), offset)
        if not turns:
            return after(link.pose, (IDENTITY[0], scaled(axis, value)))
        sine, cosine = sin_cos(value)
        x, y, z = scaled(axis, sine)
        skew = [[ZERO, neg(z), y], [z, ZERO, neg(x)], [neg(y), x, ZERO]]
        along = [scaled(axis, mul(a, sub(UNIT, cosine))) for a in axis]
        turn = [[total((along[i][j], skew[i][j], cosine if i == j else ZERO)) for j in range(3)] for i in range(3)]
        return after(link.pose, (turn, [ZERO] * 3))


class Moved:
    """A part of an object in a common frame: pose, velocity, and a bound on the acceleration of its points (6)."""

    def __init__(self, scene, moment, top, of, span):
        self.object, self.span, self.pose = scene.objects[of], span, IDENTITY
        joints, before = [], 0
        for i in scene.chain(top, of):
            self.pose = after(self.pose, moment.links[i])
            if scene.objects[i].motion:
                turns, joint, factor, _, axis = scene.objects[i].motion
                size = mag(factor)
                fastest, bend = [mul((most, most), size)[1] for most in (moment.fastest[joint], moment.bend[joint])]
                rate = mul(moment.rate[joint], factor)
                joints.append((turns, self.pose[1], times(self.pose[0], axis), rate, fastest, bend, before))
                before += fastest if turns else 0
        self.velocity, self.turn, self.center, self.bend = [ZERO] * 3, [ZERO] * 3, [ZERO] * 3, ZERO
        if not joints:
            return
        center, radius = self.object.ball(span)
        self.center = plus(times(self.pose[0], center), self.pose[1])
        beyond = 0
        for turns, origin, axis, rate, fastest, bend, before in reversed(joints):
            point = lambda x: (x, x)
            if turns:
                arm = cross(axis, plus(self.center, minus(origin)))
                reach = (0, length(arm)[1] + radius[1] + beyond // 2 + 1)
                self.velocity = plus(self.velocity, scaled(arm, rate))
                self.turn = plus(self.turn, scaled(axis, rate))
                speed = mul(point(fastest), reach)
                grown = add(mul(speed, point(fastest + 2 * before)), mul(point(bend), reach))
            else:
                self.velocity = plus(self.velocity, scaled(axis, rate))
                speed = (0, fastest)
                grown = add(mul(point(2 * fastest), point(before)), point(bend))
            self.bend, beyond = add(self.bend, grown), beyond + speed[1]

    def reach(self, n, s):
        """Returns an upper bound of n·(p + s·p'), in units of 2^-96."""
        turned = scaled(cross(n, self.turn), s)
        local = self.object.support(self.span, times(transposed(self.pose[0]), plus(n, turned)))
        rest = add(dot(plus(n, turned), self.pose[1]), mul(s, dot(n, self.velocity)))
        return local + sub(rest, dot(turned, self.center))[1]


class Path:
    """Pieces of a path, with their proofs."""

    def __init__(self, scene):
        self.scene, self.points, self.end, self.next, self.outside = scene, [], None, 0, set()
        self.moments, self.is_new, self.work = {}, True, 0

    def control_point(self, q):
        unless(self.next == 0 and len(self.points) < MOST["points"], "a control point at this place")
        for (name, lower, upper), x in zip(self.scene.joints, q):
            if not lower <= x <= upper:
                raise Refused(f"{name} is outside its limits")
        if not self.points:  # (10)
            from_, tolerance = (self.scene.start, Fraction(1e-5)) if self.end is None else (self.end, 0)
            if any(abs(a - b) > tolerance for a, b in zip(q, from_)):
                raise Refused("the piece does not begin where the path is")
        self.points.append(q)

    def pair(self, words):
        unless(len(self.points) >= 2 and len(words) >= 2, "a pair before two control points")
        stated = tuple(index(word, len(self.scene.objects)) for word in words[:2])
        if self.next >= len(self.scene.pairs) or self.scene.pairs[self.next][:2] != stated:
            raise Refused("the proof of another pair is missing")
        self.prove(*self.scene.pairs[self.next], words[2:])
        self.next += 1

    def prove(self, a, b, margin, marks):
        """(8) Walks through the tree of a pair in prefix order."""
        objects = self.scene.objects[a], self.scene.objects[b]
        curve = [[exact(x) for x in q] for q in self.points]
        stack, plane = [(curve, "", objects[0].whole(), objects[1].whole(), 0)], None
        for mark in marks:
            unless(stack, "more marks than the proof has nodes")
            curve, time, of_a, of_b, depth = stack.pop()
            unless(depth < MOST["halvings"] and len(time) <= 60, "too many halvings")
            if mark == "h":
                first, second = halves(curve)
                stack += [(second, time + "1", of_a, of_b, depth + 1), (first, time + "0", of_a, of_b, depth + 1)]
            elif mark == "a":
                stack += [(curve, time, part, of_b, depth + 1) for part in objects[0].halves(of_a)[::-1]]
            elif mark == "b":
                stack += [(curve, time, of_a, part, depth + 1) for part in objects[1].halves(of_b)[::-1]]
            else:
                if mark not in ("~", "="):
                    plane = self.normal(mark)
                unless(plane or mark == "=", "no plane before")
                whole = objects[0].has_whole_meshes(of_a) and objects[1].has_whole_meshes(of_b)
                unless(margin >= 0 or whole, "an allowed overlap needs planes for the whole mesh")
                sizes = [len(solid.points) + len(solid.faces) + 100 for known in objects for solid in known.solids]
                self.work += sum(sizes) + len(self.scene.objects)
                unless(self.work <= MOST_WORK, "more work than a path may take")
                if time not in self.moments:
                    self.moments[time] = Moment(self.scene, curve)
                self.separates(a, b, margin, self.moments[time], of_a, of_b, None if mark == "=" else plane)
                if whole and any(solid.faces for known in objects for solid in known.solids):
                    self.outside |= {(a, b, i, j) for i in range(*of_a[:2]) for j in range(*of_b[:2])}
        if stack:
            raise Refused("the proof ends before it covers the piece")

    @staticmethod
    def normal(mark):
        found = PLANE.fullmatch(mark)
        unless(found, "a mark that is none")
        n = [int(word) for word in found.groups()]
        unless(any(n) and all(-32768 <= x <= 32767 for x in n), "a mark that is none")
        return [(x * ONE, x * ONE) for x in n]

    def separates(self, a, b, margin, moment, of_a, of_b, n):
        """(7) Checks that the plane keeps both parts apart along the interval."""
        top = self.scene.common(a, b)
        first, second = Moved(self.scene, moment, top, a, of_a), Moved(self.scene, moment, top, b, of_b)
        floor = None
        if n is None:
            solid = second.object.solids[of_b[0]]
            unless(of_b[1] == of_b[0] + 1 and solid.kind == "half", "no half-space")
            up = [row[2] for row in solid.pose[0]]
            n, floor = minus(up), dot(up, solid.pose[1])[1]
        bend = mul(add(first.bend, second.bend), exact(Fraction(1, 8)))
        needed = mul(length(n), add(exact(margin), bend))[1]
        for s in (neg(HALF), HALF):
            gap = -(first.reach(n, s) + (second.reach(minus(n), s) if floor is None else floor))
            if not gap > needed:
                names = f"{first.object.name} and {second.object.name}"
                raise Refused(f"the plane does not keep {names} apart: {float(needed - gap) / ONE:.3g} are missing")

    def end_piece(self):
        unless(len(self.points) >= 2, "a piece without two control points")
        if self.next < len(self.scene.pairs):
            raise Refused("the proof of a pair is missing")
        self.end, self.points, self.next, self.moments = self.points[-1], [], 0, {}

    def end_path(self):
        self.end_piece()
        moment = Moment(self.scene, [[exact(x) for x in self.end]] * 2)
        tip = IDENTITY
        for i in self.scene.chain(None, self.scene.tip):
            tip = after(tip, moment.links[i])
        degree = sin_cos(mul((2 * QUARTER[0], 2 * QUARTER[1]), exact(Fraction(1, 180))))[1]
        for rotation, place in self.scene.goals:  # (11)
            far = total(square(sub(x, y)) for x, y in zip(tip[1], place))
            trace = total(dot(x, y) for x, y in zip(tip[0], rotation))
            if far[1] <= exact(Fraction(1, 10**6))[0] and trace[0] >= ONE + 2 * degree[1]:
                break
        else:
            raise Refused("the path ends at no goal")
        for a, b, _ in self.scene.pairs:  # (9)
            for i, of_a in enumerate(self.scene.objects[a].solids):
                for j, of_b in enumerate(self.scene.objects[b].solids):
                    if (of_a.faces or of_b.faces) and (a, b, i, j) not in self.outside:
                        raise Refused("no plane shows that two solids are not inside each other")


def check(text, report):
    """Checks a certificate line by line; `report` receives the number of each line."""
    unless(text.endswith("\n"), "a line without an end")
    lines = text[:-1].split("\n")
    unless(lines[0] == "cranny-certificate/1", "the format is not `cranny-certificate/1`")
    found, scene, path, count, begin = [], None, None, 0, 1
    for at, line in enumerate(lines[1:], 1):
        report(at + 1)
        words = line.split(" ")
        if words[0] == "end" or (words[0] == "scene" and (scene is None or scene.hash)):
            if scene:
                unless(path, "no path")
                path.end_path()
            if line == "end":
                unless(scene and scene.hash and at + 1 == len(lines), "an end at another place")
                return found
            scene, path, begin = Scene(scene and (scene, path.end)), None, at
            unless(sum(len(known.objects) ** 2 for known in found) < 4 * MOST["object"] ** 2, "too many objects")
        if scene is None or not scene.hash:
            unless(scene, "a scene begins with its name")
            if words[0] == "hash":
                hash_ = hashlib.sha256("".join(line + "\n" for line in lines[begin:at]).encode()).hexdigest()
                if words[1:] != [hash_]:
                    raise Refused(f"the scene has the hash {hash_}")
                scene.finish(hash_)
                found.append(scene)
            else:
                scene.line(words)
        elif words[0] == "path":
            if path:
                path.end_path()
            path, scene.paths = Path(scene), scene.paths + 1
        elif line == "piece" and path:
            if not path.is_new:
                path.end_piece()
            path.is_new = False
        elif words[0] == "q" and path and not path.is_new:
            path.control_point(numbers(words[1:], len(scene.joints)))
        elif words[0] == "p" and path:
            path.pair(words[1:])
        else:
            raise Malformed("a line of no known kind, or not at this place")
    raise Malformed("the certificate has no end")


def main(arguments):
    if len(arguments) != 2:
        print("usage: check.py FILE", file=sys.stderr)
        return 2
    at = [1]
    try:
        with open(arguments[1], "rb") as file:
            data = file.read((64 << 20) + 1)
        unless(len(data) <= 64 << 20, "more than 64 MiB")
        scenes = check(data.decode(), lambda line: at.__setitem__(0, line))
    except (OSError, UnicodeDecodeError) as fault:
        print(f"{arguments[1]}: {fault}", file=sys.stderr)
        return 2
    except Malformed as fault:
        print(f"{arguments[1]}:{at[0]}: {fault}", file=sys.stderr)
        return 2
    except Refused as fault:
        print(f"not certified: {arguments[1]}:{at[0]}: {fault}")
        return 1
    print("certified")
    for scene in scenes:
        print(f"  scene       {scene.name} {scene.hash}\n  paths       {scene.paths}\n  pairs       {len(scene.pairs)}")
        print("".join(f"  {line}\n" for line in scene.exceptions), end="")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv))
