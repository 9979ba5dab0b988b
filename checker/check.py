#!/usr/bin/env python3
"""Checks a certificate of a motion, `cranny-certificate/1`: see docs/certificate.md, whose inequalities the comments cite.

Whole numbers and fractions alone, from the standard library. It shares no code with the checker in Rust.
"""

import hashlib
import os
import re
import sys
from bisect import bisect_left
from decimal import Decimal
from fractions import Fraction
from math import isqrt

S = 96  # (1) Ends of intervals are whole multiples of 2^-96.
ONE = 1 << S
HALF, ZERO, UNIT = (ONE // 2, ONE // 2), (0, 0), (ONE, ONE)
LARGEST, MOST_HALVINGS, MOST_POINTS, MOST_WORK, MOST_BYTES = 10**6, 96, 100, 1_000_000_000, 64 << 20
MOST_LINES, MOST_VALUES = 4_000_000, 2_000_000
SIZES = {"box": 3, "ball": 1, "capsule": 2, "cylinder": 2, "half": 0, "hull": 1, "mesh": 0}

WORD, WHOLE = re.compile("[!-~]+"), re.compile("0|[1-9][0-9]{0,8}")
NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)(e[+-]?[0-9]+)?", re.ASCII | re.IGNORECASE)
PLANE = re.compile(",".join(["(0|-?[1-9][0-9]{0,4})"] * 3))
USAGE, spent = "usage: check.py FILE", 0


class Refused(Exception):
    """The reason why a line is not of the format, or does not hold."""


def unless(holds, reason):
    if not holds:
        raise Refused(reason)


def spend(work):
    """Counts work, in units of about half a microsecond, and fails beyond the limit."""
    global spent
    spent += work
    unless(spent <= MOST_WORK, "more work than a certificate may take")


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


def up(a, b):
    """Returns an upper bound of a product of two bounds that are not negative."""
    return -(-a * b >> S)


def over(a, b):
    unless(b[0] > 0, "a division by zero")
    return (min(a[0] * ONE // b[0], a[0] * ONE // b[1]), max(-(-a[1] * ONE // b[0]), -(-a[1] * ONE // b[1])))


def mag(a):
    return (0 if a[0] <= 0 <= a[1] else min(abs(a[0]), abs(a[1])), max(abs(a[0]), abs(a[1])))


def root(a):
    return (isqrt(max(a[0], 0) << S), isqrt(max(a[1], 0) << S) + 1)


def square(a):
    m = mag(a)
    return mul(m, m)


def total(values):
    ends = list(zip(*values))
    return (sum(ends[0]), sum(ends[1]))


def dot(a, b):
    x, y, z = map(mul, a, b)
    return (x[0] + y[0] + z[0], x[1] + y[1] + z[1])


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
    spend(400)
    k = round(Fraction(x[0] + x[1], 2 * QUARTER[0]))
    r = (x[0] - max(k * QUARTER[0], k * QUARTER[1]), x[1] - min(k * QUARTER[0], k * QUARTER[1]))
    if mag(r)[1] >= ONE:
        return (-ONE, ONE), (-ONE, ONE)
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


def numbers(words, count, least=-LARGEST):
    unless(len(words) == count, f"{count} numbers are expected")
    found = [number(word) for word in words]
    unless(all(x >= least for x in found), "a size is not negative")
    return found


def index(word, below):
    unless(WHOLE.fullmatch(word) and int(word) < below, "an index out of range")
    return int(word)


def has_size(values):
    """Checks the greatest number of a quaternion or a direction."""
    unless(0.001 <= max(map(abs, values)) <= 1000, "a quaternion or a direction that is too short or too long")


def unit(words):
    """Returns the unit vector of a direction."""
    has_size(values := numbers(words, 3))
    axis = [exact(x) for x in values]
    return [over(x, length(axis)) for x in axis]


def pose(words):
    """Returns rotation and translation of x y z qw qx qy qz; the quaternion is scaled to length 1."""
    x, y, z, w, a, b, c = numbers(words, 7)
    spend(400)
    has_size((w, a, b, c))
    s = w * w + a * a + b * b + c * c
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

    def __init__(self, lines):
        self.kind, self.points, self.faces = lines.kind(), [], []
        words = lines.read(self.kind)
        self.pose, self.sizes = pose(words[:7]), [exact(x) for x in numbers(words[7:], SIZES[self.kind], 0)]
        self.inverse = transposed(self.pose[0])
        while lines.kind() == "v" and self.kind in ("hull", "mesh"):
            self.points.append([exact(x)[0] for x in numbers(lines.read("v"), 3)])
        while lines.kind() == "f" and self.kind == "mesh":
            self.faces.append([index(word, len(self.points)) for word in lines.read("f", 3)])
        # The box around the solid, in the frame of the object.
        if self.kind in ("hull", "mesh"):
            unless(self.points and bool(self.faces) == (self.kind == "mesh"), "a solid without points or faces")
            self.largest = [max(abs(point[i]) for point in self.points) + 1 for i in range(3)]
        if self.kind != "half":
            axis = lambda i, sign: [(sign * ONE,) * 2 if j == i else ZERO for j in range(3)]
            self.box = [[s * self.support(axis(i, s), (0, len(self.faces))) for i in range(3)] for s in (-1, 1)]

    def support(self, n, faces):
        """(4) Returns an upper bound of n·p over the solid, or these faces."""
        spend(100)
        m = times(self.inverse, n)
        base, h = dot(n, self.pose[1])[1], self.sizes
        if self.kind == "box":
            return base + total(mul(mag(m[i]), h[i]) for i in range(3))[1]
        if self.kind in ("ball", "capsule", "cylinder"):
            across, (*half, radius) = length(m[:2] if self.kind == "cylinder" else m), h
            return base + total([mul(across, radius), *(mul(mag(m[2]), x) for x in half)])[1]
        unless(self.kind != "half", "a half-space needs its own plane")
        points = self.points
        if faces != (0, len(self.faces)):
            points = [points[i] for i in {i for face in self.faces[faces[0] : faces[1]] for i in face}]
        spend(2 * len(points))
        middle = [(x[0] + x[1]) // 2 for x in m]
        a, b, c = middle
        far = max(a * p[0] + b * p[1] + c * p[2] for p in points)
        error = sum((m[i][1] - m[i][0] + 1) * self.largest[i] + abs(middle[i]) + 1 for i in range(3))
        base += ((far + error) >> S) + 1
        return base + (mul(length(m), h[0])[1] if self.kind == "hull" else 0)


    def contains(self, center, radius=0):
        """(14, 15) Returns true if a ball, in the frame of the object, is in the solid; always false for hulls and meshes."""
        spend(100)
        x, y, z = times(self.inverse, plus(center, minus(self.pose[1])))
        if self.kind == "half":
            return z[1] + radius <= 0
        if self.kind == "box":
            return all(mag(a)[1] + radius <= h[0] for a, h in zip((x, y, z), self.sizes))
        across, beyond = length([x, y]), mag(z)[1] - (self.sizes[0][0] if len(self.sizes) == 2 else 0)
        if self.kind == "cylinder":
            return beyond + radius <= 0 and across[1] + radius <= self.sizes[-1][0]
        far = across if beyond <= 0 else length([across, (beyond,) * 2])
        return self.kind in ("ball", "capsule") and far[1] + radius <= self.sizes[-1][0]


class Object:
    """A link or a body."""

    def __init__(self, name, is_body):
        self.name, self.is_body, self.solids, self.title, self.key = name, is_body, [], "", "-"
        self.parent, self.pose, self.motion = None, IDENTITY, None

    def span(self, begin, end):
        return (begin, end, 0, len(self.solids[begin].faces) if end == begin + 1 else 0)

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


class Lines:
    """Lines of a certificate; `number` is that of the line that was read last, from 1."""

    def __init__(self, text):
        self.lines, self.at, self.number = text.split("\n"), 0, 1
        # What follows the last line feed is no line; `check` refuses a second empty one.
        self.lines[-1:] = ["", ""] if self.lines[-1] else [""]

    def repeat(self):
        """Puts the lines that a line `= FROM COUNT` repeats in its place, with its number; another such line among them is of no
        known kind."""
        lines, self.numbers, size = [], [], -1
        for self.number, line in enumerate(self.lines, 1):
            again = [line]
            if line.startswith("= "):
                given = [int(word) if WHOLE.fullmatch(word) else 0 for word in line.split(" ")[1:]]
                begin, count = given if len(given) == 2 else (0, 0)
                fault = "FROM and COUNT of lines to repeat that are all before are expected"
                unless(begin > 0 < count <= self.number - begin, fault)
                again = self.lines[begin - 1 : begin - 1 + count]
            size += sum(len(known) + 1 for known in again)
            is_small = size <= MOST_BYTES and len(lines) + len(again) <= MOST_LINES + 1
            unless(is_small, "more text than a certificate may have, with repeated lines")
            lines += again
            self.numbers += [self.number] * len(again)
        self.lines = lines

    def kind(self):
        return self.lines[self.at].split(" ")[0]

    def read(self, kind, count=None):
        """Returns the words after this first word, of which there must be so many."""
        self.number = self.numbers[self.at]
        first, *words = self.lines[self.at].split(" ")
        unless(first == kind != "", f"a line `{kind}` is missing here, or this one is of no known kind")
        is_usual = all(map(WORD.fullmatch, words)) and count in (None, len(words))
        unless(is_usual, "a count of words that is not expected, or one not of printable ASCII characters")
        spend(20 + 10 * len(words))
        self.at += 1
        return words


class Scene:
    """Robot, world and rules."""

    def __init__(self, lines):
        begin = lines.at
        (self.name,) = lines.read("scene", 1)
        self.joints, self.objects, self.distances, self.rules, self.bounds, self.goals = [], [], {}, [], [], []
        while lines.kind() == "joint":
            name, *limits = lines.read("joint", 3)
            self.joints.append((name, *numbers(limits, 2)))
        while lines.kind() in ("link", "body"):
            self.read_object(lines)
        unless(len({known.name for known in self.objects}) == len(self.objects), "two objects have the same name")
        self.margin_word = lines.read("margin", 1)
        (self.margin,) = numbers(self.margin_word, 1, 0)
        while lines.kind() in ("keep", "skip"):
            self.read_exception(lines.kind(), *lines.read(lines.kind(), 3))
        while lines.kind() in ("cone", "inside", "near"):
            self.read_bound(lines.kind(), *lines.read(lines.kind()))
        self.start = numbers(lines.read("start"), len(self.joints))
        self.tip = index(lines.read("tip", 1)[0], len(self.objects))
        unless(self.joints and not self.objects[self.tip].is_body, "no joint, or the tip is no link")
        while lines.kind() == "goal" or not self.goals:
            self.goals.append(pose(lines.read("goal", 8)[1:]))
            self.rules.append(lines.lines[lines.at - 1])
        text = "".join(line + "\n" for line in lines.lines[begin : lines.at])
        self.hash = hashlib.sha256(text.encode()).hexdigest()
        unless(lines.read("hash", 1) == [self.hash], f"the scene has the hash {self.hash}")
        unless(len(self.objects) <= 4096, "more work than a certificate may take")
        self.list_pairs()

    def read_object(self, lines):
        begin = lines.at
        known = Object(lines.read("body", 1)[0], True) if lines.kind() == "body" else self.link(*lines.read("link"))
        words = lines.lines[begin].split(" ")
        if known.parent is not None:
            words[2], known.key = self.objects[known.parent].name, self.objects[known.parent].key
        while lines.kind() in SIZES:
            unless(known.is_body or lines.kind() != "half", "a link cannot be a half-space")
            known.solids.append(Solid(lines))
        known.title = " ".join(words)
        known.key = hashlib.sha256("\n".join([known.key, known.title, *lines.lines[begin + 1 : lines.at]]).encode()).hexdigest()
        self.objects.append(known)

    def link(self, name="", parent="", *rest):
        link = Object(name, False)
        unless(not any(known.is_body for known in self.objects), "links come before bodies")
        link.parent = index(parent, len(self.objects)) if self.objects else None
        unless(self.objects or parent == "-", "the first link is the root, with the parent `-`")
        link.pose = pose(rest[:7])
        if rest[7:] != ("fixed",):
            unless(len(rest) == 14 and rest[7] in ("turn", "slide"), "a motion that is none")
            joint, (factor, offset) = index(rest[8], len(self.joints)), map(float, numbers(rest[9:11], 2))
            most = max(abs(factor * float(limit)) for limit in self.joints[joint][1:]) + abs(offset)
            unless(most <= LARGEST, "a link can turn or slide too far")
            link.motion = (rest[7] == "turn", joint, exact(factor), exact(offset), unit(rest[11:]))
        return link

    def read_exception(self, kind, a, b, last):
        pair = index(a, len(self.objects)), index(b, len(self.objects))
        unless(pair[0] < pair[1] and pair not in self.distances, "each pair once, the lower index first")
        self.distances[pair] = number(last) if kind == "keep" else None
        self.rules.append(" ".join([kind, *(self.objects[i].name for i in pair), last]))

    def read_bound(self, kind, name="", link="", *rest):
        """(12) A point or direction of a link, a pose, half extents and a radius around it, of which one is infinite."""
        of, place, half, radius = index(link, len(self.objects)), IDENTITY, None, None
        unless(not self.objects[of].is_body, "a bound is of a link")
        point = [exact(x) for x in numbers(rest[:3], 3)]
        if kind == "inside":
            place, half = pose(rest[3:10]), [exact(x)[0] for x in numbers(rest[10:], 3)]
        else:
            (radius,) = numbers(rest[6:], 1, 0)
            place = IDENTITY[0], [exact(x) for x in numbers(rest[3:6], 3)]
            if kind == "cone":
                unless(radius <= Fraction(3.1), "an angle out of range")
                point, place = unit(rest[:3]), (IDENTITY[0], unit(rest[3:6]))
            radius = 2 * sin_cos(exact(radius / 2))[0][0] if kind == "cone" else exact(radius)[0]
        self.bounds.append((of, kind == "cone", point, place, half, radius))
        self.rules.append(" ".join([kind, name, self.objects[of].name, *rest]))

    def chain(self, top, of):
        chain, at = [], None if self.objects[of].is_body else of
        while at is not None and at != top:
            chain.append(at)
            at = self.objects[at].parent
        spend(2 + len(chain) // 4)
        return chain[::-1]

    def list_pairs(self):
        """Lists the pairs that must be proven."""
        self.pairs = []
        for a, first in enumerate(self.objects):
            for b in range(a + 1, len(self.objects)) if first.solids and not first.is_body else ():
                distance, (top, moves) = self.distances.get((a, b), self.margin), self.common(a, b)
                if self.objects[b].solids and moves and distance is not None:
                    self.pairs.append((a, b, top, distance))

    def pairs_line(self):
        margin = format(Decimal(repr(float(self.margin_word[0]))).normalize(), "f")
        return f"pairs {len(self.pairs)}, at least {margin} m apart but for `keep`"

    def common(self, a, b):
        """Returns the lowest link above two objects or equal to one, and if a joint moves one against the other."""
        same = [x for x, y in zip(self.chain(None, a), self.chain(None, b)) if x == y]
        top = same[-1] if same else None
        return top, any(self.objects[i].motion for end in (a, b) for i in self.chain(top, end))

    def changes_since(self, before):
        """Lists the objects that only one of two scenes has; all else of the robot is the same (13)."""
        is_same = self.joints == before.joints and self.objects[self.tip].key == before.objects[before.tip].key
        unless(is_same, "joints, or links down to the tip, are not those before (13)")
        changes = []
        for sign, new, old in (("-", before, self), ("+", self, before)):
            known = {thing.key for thing in old.objects}
            for i, thing in enumerate(new.objects):
                if thing.key not in known:
                    unless(thing.is_body or not new.common(new.tip, i)[1], "a joint moves a link that differs (13)")
                    changes.append(f"{sign} {thing.title}")
        return changes


def halves(curve):
    spend(2 * len(curve) ** 2 * len(curve[0]))
    first, second = [curve[0]], [curve[-1]]
    while len(curve) > 1:
        curve = [[mul(add(x, y), HALF) for x, y in zip(a, b)] for a, b in zip(curve, curve[1:])]
        first, second = [*first, curve[0]], [*second, curve[-1]]
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
        spend(200)
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

    def __init__(self, scene, moment, top, of, span, ball=None):
        self.object, self.span, self.pose = scene.objects[of], span, IDENTITY
        joints, before = [], 0
        for i in scene.chain(top, of):
            spend(200)
            self.pose = after(self.pose, moment.links[i])
            if scene.objects[i].motion:
                turns, joint, factor, _, axis = scene.objects[i].motion
                fastest, bend = [up(most, mag(factor)[1]) for most in (moment.fastest[joint], moment.bend[joint])]
                rate, axis = mul(moment.rate[joint], factor), times(self.pose[0], axis)
                joints.append((turns, self.pose[1], axis, rate, fastest, bend, before))
                before += fastest if turns else 0
        self.velocity, self.turn, self.center = [ZERO] * 3, [ZERO] * 3, [ZERO] * 3
        self.bend = self.swing = beyond = 0
        if not joints and not ball:
            return
        center, radius = ball or self.object.ball(span)
        self.center = plus(times(self.pose[0], center), self.pose[1])
        for turns, origin, axis, rate, fastest, bend, before in reversed(joints):
            arm, reach, bend = axis, ONE, bend + up(2 * fastest, before)
            if turns:
                arm = cross(axis, plus(self.center, minus(origin)))
                reach = length(arm)[1] + radius[1] + beyond // 2 + 1
                bend += up(fastest, fastest)
                self.turn, self.swing = plus(self.turn, scaled(axis, rate)), self.swing + bend
            self.velocity = plus(self.velocity, scaled(arm, rate))
            self.bend, beyond = self.bend + up(reach, bend), beyond + up(fastest, reach)

    def reach(self, n, s):
        """Returns an upper bound of n·(p + s·p'), in units of 2^-96."""
        turned = scaled(cross(n, self.turn), s)
        local = self.object.support(self.span, times(transposed(self.pose[0]), plus(n, turned)))
        rest = add(dot(plus(n, turned), self.pose[1]), mul(s, dot(n, self.velocity)))
        return local + sub(rest, dot(turned, self.center))[1]


def normal(mark):
    unless(PLANE.fullmatch(mark), "a mark that is none")
    n = [int(word) for word in mark.split(",")]
    unless(any(n) and all(-32768 <= x <= 32767 for x in n), "a mark that is none")
    return [(x * ONE, x * ONE) for x in n]


class Piece:
    """A piece of a path, with its proofs."""

    def __init__(self, scene, points, outside):
        self.scene, self.outside, self.moments = scene, outside, {}
        self.curve = [[exact(x) for x in q] for q in points]

    def leaves(self, a, b, marks):
        """(8) Walks through a tree in prefix order: yields each leaf with its moment and the parts of both objects."""
        objects = self.scene.objects[a], self.scene.objects[b]
        whole = [known.span(0, len(known.solids)) for known in objects]
        stack, marks = [(self.curve, "", *whole, 0)], iter(marks)
        while stack:
            curve, time, of_a, of_b, depth = stack.pop()
            mark = next(marks, None)
            unless(mark is not None and depth <= MOST_HALVINGS, "a mark is missing, or too many halvings")
            if mark == "h":
                first, second = halves(curve)
                stack += [(second, time + "1", of_a, of_b, depth + 1), (first, time + "0", of_a, of_b, depth + 1)]
            elif mark in ("a", "b"):
                one, two = objects["ab".index(mark)].halves(of_a if mark == "a" else of_b)
                parts = [(two, of_b), (one, of_b)] if mark == "a" else [(of_a, two), (of_a, one)]
                stack += [(curve, time, *part, depth + 1) for part in parts]
            else:
                if time not in self.moments:
                    self.moments[time] = Moment(self.scene, curve)
                yield mark, self.moments[time], of_a, of_b
        unless(next(marks, None) is None, "more marks than the proof has nodes")

    def prove(self, pair, marks):
        a, b, _, margin = pair
        objects, plane = (self.scene.objects[a], self.scene.objects[b]), None
        for mark, moment, of_a, of_b in self.leaves(a, b, marks):
            if mark not in ("~", "="):
                plane = normal(mark)
            unless(plane or mark == "=", "no plane before")
            whole = objects[0].has_whole_meshes(of_a) and objects[1].has_whole_meshes(of_b)
            unless(margin >= 0 or whole, "an allowed overlap needs planes for whole meshes")
            self.separates(pair, moment, of_a, of_b, None if mark == "=" else plane)
            if whole:
                spend((of_a[1] - of_a[0]) * (of_b[1] - of_b[0]))
                self.outside |= {(a, b, i, j) for i in range(*of_a[:2]) for j in range(*of_b[:2])}

    def separates(self, pair, moment, of_a, of_b, n):
        """(7) Checks that the plane keeps both parts apart along the interval."""
        a, b, top, margin = pair
        first, second = Moved(self.scene, moment, top, a, of_a), Moved(self.scene, moment, top, b, of_b)
        floor = None
        if n is None:
            solid = second.object.solids[of_b[0]]
            unless(of_b[1] == of_b[0] + 1 and solid.kind == "half", "no half-space")
            upward = [row[2] for row in solid.pose[0]]
            n, floor = minus(upward), dot(upward, solid.pose[1])[1]
        bend = (first.bend + second.bend) // 8 + 1
        needed = mul(length(n), add(exact(margin), (0, bend)))[1]
        for s in (neg(HALF), HALF):
            gap = -(first.reach(n, s) + (second.reach(minus(n), s) if floor is None else floor))
            unless(gap > needed, f"the plane does not keep both parts apart: {float(needed - gap) / ONE:.3g} are missing")

    def prove_bound(self, bound, marks):
        """(12) Checks that a point or direction stays near its place."""
        of, is_direction, point, (turn, place), half, radius = bound
        for mark, moment, _, _ in self.leaves(of, of, marks):
            unless(mark == ".", "a mark that is none")
            moved = Moved(self.scene, moment, None, of, (0, 0, 0, 0), (point, ZERO))
            at, rate, bend = moved.center, moved.velocity, moved.bend
            if is_direction:
                at = times(moved.pose[0], point)
                rate, bend = cross(moved.turn, at), moved.swing
            rest = bend // 8 + 1
            for s in (neg(HALF), HALF):
                off = plus(plus(at, minus(place)), scaled(rate, s))
                inside = [mag(x)[1] + rest for x in times(transposed(turn), off)]
                holds = length(off)[1] + rest < radius if half is None else all(x < h for x, h in zip(inside, half))
                unless(holds, "a bound is not shown to be kept")


def check_path(lines, scene):
    """Checks a path (10), and returns the number of its pieces and its end."""
    lines.read("path", 1)
    end, pieces, outside = None, 0, set()
    while not pieces or lines.kind() == "piece":
        lines.read("piece", 0)
        points = []
        while len(points) < 2 or lines.kind() == "q":
            points.append(numbers(lines.read("q"), len(scene.joints)))
            unless(len(points) <= MOST_POINTS, "more control points than a piece may have")
            unless(all(a <= x <= b for (_, a, b), x in zip(scene.joints, points[-1])), "a joint is outside its limits")
        from_, tolerance = (scene.start, Fraction(1e-5)) if end is None else (end, 0)
        unless(all(abs(a - b) <= tolerance for a, b in zip(points[0], from_)), "the piece does not begin where the path is")
        piece = Piece(scene, points, outside)
        for pair in scene.pairs:
            try:
                piece.prove(pair, lines.read("p"))
            except Refused as fault:
                raise Refused(f"{scene.objects[pair[0]].name}, {scene.objects[pair[1]].name}: {fault}") from fault
        for bound in scene.bounds:
            piece.prove_bound(bound, lines.read("b"))
        end, pieces = points[-1], pieces + 1
    check_end(scene, end)
    solids = lambda i: len(scene.objects[i].solids)
    complete = len(outside) == sum(solids(a) * solids(b) for a, b, *_ in scene.pairs)  # (9)
    unless(complete, "no plane shows that two objects are not inside each other")
    return pieces, end


def place(scene, values, of):
    """Encloses the pose of an object in the world wherever the joints are in a box."""
    at = IDENTITY
    for i in scene.chain(None, of):
        at = after(at, Moment.local(scene.objects[i], values))
    return at


def slides_alone(scene, of):
    """Checks that no joint turns an object: both checkers then enclose its pose in the same way."""
    turned = of is not None and any(scene.objects[i].motion and scene.objects[i].motion[0] for i in scene.chain(None, of))
    unless(not turned, "a joint turns what only slides may move")


def touch(scene, mark):
    """Reads a mark A,I,B,K,X,Y,Z or A,I,B,K,vN: objects that must not touch, a solid of each, a point of A, and if it is a vertex."""
    words = mark.split(",")
    vertex = words[4][1:] if len(words) == 5 and words[4].startswith("v") else None
    unless(len(words) == 7 or vertex is not None, "a mark that is none")
    a, b = [index(word, len(scene.objects)) for word in words[:4:2]]
    pair = (min(a, b), max(a, b))
    place_of_pair = bisect_left(scene.pairs, pair)  # Pairs are in lexicographic order.
    known = scene.pairs[place_of_pair : place_of_pair + 1]
    unless(known and known[0][:2] == pair and known[0][3] >= 0, "a pair that may touch")
    solids = [scene.objects[of].solids for of in (a, b)]
    of_a, of_b = [known[index(word, len(known))] for known, word in zip(solids, words[1:4:2])]
    if vertex is None:
        return a, b, of_a, of_b, [exact(x) for x in numbers(words[4:], 3)], False
    number = index(vertex, len(of_a.points))
    spend(2 + len(of_a.faces) // 2)
    unless(not of_a.faces or any(number in face for face in of_a.faces), "a vertex of no face")
    at = [(x, x + 1) for x in of_a.points[number]]
    return a, b, of_a, of_b, plus(times(of_a.pose[0], at), of_a.pose[1]), True


def blocked_goal(scene, words):
    """(15) Checks that the hand touches the world wherever the tip is near a goal, and returns the goal."""
    unless(len(words) == 2, "a goal, and a mark, and no more")
    goal, (a, b, of_a, of_b, point, is_vertex) = index(words[0], len(scene.goals)), touch(scene, words[1])
    to_a, to_b, to_tip = [scene.chain(None, of) for of in (a, b, scene.tip)]
    shared = sum(x == y for x, y in zip(to_a, to_tip))
    rigid = [scene.objects[i] for i in [*to_a[shared:], *to_tip[shared:], *to_b]]
    unless(not any(known.motion for known in rigid), "a joint moves the hand against the tip, or the other object")
    spend(40 * (len(rigid) + 10))
    outer = lambda pose, at: plus(times(pose[0], at), pose[1])
    inner = lambda at, pose: times(transposed(pose[0]), plus(at, minus(pose[1])))
    in_tip = point
    for i in reversed(to_a[shared:]):
        in_tip = outer(scene.objects[i].pose, in_tip)
    for i in to_tip[shared:]:
        in_tip = inner(in_tip, scene.objects[i].pose)
    in_b = outer(scene.goals[goal], in_tip)
    for i in to_b:
        in_b = inner(in_b, scene.objects[i].pose)
    moved = add(exact(Fraction(1, 1000)), mul(exact(Fraction("0.0174530709968")), length(in_tip)))  # 2 sin ½°, rounded up.
    is_in_a = is_vertex or of_a.contains(point, moved[1])
    unless(is_in_a and of_b.contains(in_b, moved[1] if is_vertex else 0), "two objects that are not shown to touch")
    return goal


def open_boxes(scene, marks):
    """(14) Walks through a tree of boxes in prefix order, and returns those that are left open."""
    stack, marks, found = [([(exact(a)[0], exact(b)[1]) for _, a, b in scene.joints], 0)], iter(marks), []
    while stack:
        (values, depth), mark = stack.pop(), next(marks, None)
        unless(mark is not None and depth <= MOST_HALVINGS, "a mark is missing, or too many halvings")
        spend(20 + 2 * len(values))
        if mark.startswith("s"):
            j = index(mark[1:], len(values))
            low, high = values[j]
            middle = (low + high) // 2
            for half in ((middle, high), (low, middle)):
                stack.append(([*values[:j], half, *values[j + 1 :]], depth + 1))
        elif mark == ".":
            found.append(values)
            unless(len(found) * len(values) <= MOST_VALUES, "more boxes than a certificate may have")
        else:
            a, b, of_a, of_b, point, is_vertex = touch(scene, mark)
            slides_alone(scene, a)
            slides_alone(scene, b)
            (turn, at), (other, origin) = place(scene, values, a), place(scene, values, b)
            in_b = times(transposed(other), plus(plus(times(turn, point), at), minus(origin)))
            unless((is_vertex or of_a.contains(point)) and of_b.contains(in_b), "two objects that are not shown to touch")
    unless(next(marks, None) is None, "more marks than the tree has nodes")
    return found


def reach_below(scene, link, words):
    """(14) Bounds the distance of the tip from the origin of a link above it, and adds the tolerance of goals."""
    chain = scene.chain(None, scene.tip)
    unless(link in chain, "the tip is not moved by this link")
    links = [scene.objects[i] for i in chain[chain.index(link) + 1 :]]
    points = iter(numbers(words, sum(bool(known.motion and known.motion[0]) for known in links)))
    most, at = exact(Fraction(1, 1000))[1], [ZERO] * 3
    for known in links:
        if not known.motion:
            at = times(transposed(known.pose[0]), plus(at, minus(known.pose[1])))
            continue
        turns, joint, factor, offset, axis = known.motion
        following = scaled(axis, exact(next(points))) if turns else [ZERO] * 3
        if not turns:
            most += max(mag(add(mul(factor, exact(x)), offset))[1] for x in scene.joints[joint][1:])
        most += length(plus(plus(times(known.pose[0], following), known.pose[1]), minus(at)))[1]
        at = following
    return most + length(at)[1]


def check_enclosure(lines, scene):
    """(14, 15) Checks that no motion leads to a goal: returns the numbers of boxes, of those left to the start, and of blocked goals."""
    word, *points = lines.read("none")
    link = index(word, len(scene.objects))
    reach = reach_below(scene, link, points)
    rest = open_boxes(scene, lines.read("boxes"))
    count, inside, blocked = len(rest), [], set()
    while lines.kind() == "blocked":
        blocked.add(blocked_goal(scene, lines.read("blocked")))
    left = [goal for number, (_, goal) in enumerate(scene.goals) if number not in blocked]
    pending = [[add(exact(x), (-exact(Fraction(1e-5))[1], exact(Fraction(1e-5))[1])) for x in scene.start]]
    while pending:
        values = pending.pop()
        spend(len(rest) * len(values) // 2)
        meets = lambda other: all(a[0] <= b[1] and b[0] <= a[1] for a, b in zip(values, other))
        pending += filter(meets, rest)
        rest = [other for other in rest if not meets(other)]
        inside.append(values)
    unless(len(inside) > 1, "no box has the start in it")
    slides_alone(scene, scene.objects[link].parent)  # Its own turning leaves its origin in place.
    for values in inside[1:]:
        spend(30 * len(scene.goals))
        origin = place(scene, values, link)[1]
        far = [length(plus(origin, minus(goal)))[0] for goal in left]
        unless(all(x > reach for x in far), "a goal may be within reach")
    return count, len(inside) - 1, len(blocked)


def check_end(scene, end):
    """(11) Checks that the tip is at a goal."""
    moment = Moment(scene, [[exact(x) for x in end]] * 2)
    tip = Moved(scene, moment, None, scene.tip, None, ([ZERO] * 3, ZERO)).pose
    degree = sin_cos(mul((2 * QUARTER[0], 2 * QUARTER[1]), exact(Fraction(1, 180))))[1]
    for rotation, place in scene.goals:
        far = total(square(sub(x, y)) for x, y in zip(tip[1], place))
        trace = total(dot(x, y) for x, y in zip(tip[0], rotation))
        if far[1] <= exact(Fraction(1, 10**6))[0] and trace[0] >= ONE + 2 * degree[1]:
            return
    raise Refused("the path ends at no goal")


def check(lines):
    """Checks a certificate, and returns in lines what it has shown of each scene."""
    lines.repeat()
    lines.read("cranny-certificate/1", 0)
    found, before, end = [], None, None
    while not before or lines.kind() == "scene":
        scene = Scene(lines)
        found.append(f"scene {scene.name} {scene.hash}")
        if not before and lines.kind() == "none":
            count, inside, blocked = check_enclosure(lines, scene)
            found.append(f"no motion leads to a goal: {inside} of {count} boxes are left to the start")
            found.append(f"goals {len(scene.goals)}, of which {blocked} are blocked")
            found += [scene.pairs_line(), *scene.rules]
            break
        changes = scene.changes_since(before) if before else []
        unless(not before or scene.start == end, "the scene does not start where the path before it ends")
        paths = pieces = 0
        while not paths or lines.kind() == "path":
            count, end = check_path(lines, scene)
            paths, pieces = paths + 1, pieces + count
        found.append(f"paths {paths}, of {pieces} pieces")
        found += [scene.pairs_line(), *scene.rules, *changes]
        before = scene
    lines.read("end", 0)
    unless(lines.at + 1 == len(lines.lines), "a line after the end")
    return found


def main(file):
    """Returns an exit code and an answer."""
    if file in ("-h", "--help"):
        return 0, USAGE
    try:
        with open(file, "rb") as certificate:
            lines = Lines(certificate.read(MOST_BYTES + 1).decode())
        return 0, "\n  ".join(["certified", *check(lines)])
    except Refused as fault:
        return 1, f"not certified: {file}:{lines.number}: {fault}"
    except (OSError, UnicodeDecodeError) as fault:
        return 2, f"{file}: {fault}"


if __name__ == "__main__":
    code, answer = main(sys.argv[1]) if len(sys.argv) == 2 else (2, USAGE)
    try:
        print(answer, file=sys.stderr if code == 2 else sys.stdout, flush=True)
    except BrokenPipeError:  # The reader is gone. Python writes what is left at its end, so that must go elsewhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    sys.exit(code)
