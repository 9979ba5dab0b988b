"""Intersection test of two closed triangle meshes in rational numbers, without rounding.

1. The coordinates, which are binary fractions, are used exactly.
2. Two triangles meet if an edge of one meets the other, or if they are coplanar and an edge of one meets an edge of
   the other or a corner is inside the other (Möller 1997 does the same with floats).
3. If no triangles meet, one mesh may enclose the other: a ray from a point of each crosses the other's surface an odd
   number of times. Degenerate cases are avoided by another random point and ray.

It is slow, and meant for the few configurations on which two fast checks disagree.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

Vector = tuple[Fraction, Fraction, Fraction]
Triangle = tuple[Vector, Vector, Vector]
Mesh = tuple[NDArray[np.float64], NDArray[np.int64]]
"""Vertices (V, 3) in metres in a common frame, and faces (F, 3)."""


def meshes_touch(a: Mesh, b: Mesh) -> bool:
    """Whether the solids enclosed by two closed meshes have a common point."""
    near_a, near_b = _near(a, b), _near(b, a)
    if any(triangles_touch(s, t) for s in near_a for t in near_b if _boxes_meet(s, t)):
        return True
    return _holds(a, _triangles(b)[0]) or _holds(b, _triangles(a)[0])


def triangles_touch(s: Triangle, t: Triangle) -> bool:
    """Whether two triangles have a common point."""
    for one, other in ((s, t), (t, s)):
        if any(_segment_meets(one[k], one[(k + 1) % 3], other) for k in range(3)):
            return True
    return False


def _vector(values: Sequence[float] | NDArray[np.float64]) -> Vector:
    x, y, z = (Fraction(float(value)) for value in values)
    return x, y, z


def _triangles(mesh: Mesh) -> list[Triangle]:
    vertices, faces = mesh
    return [(_vector(vertices[i]), _vector(vertices[j]), _vector(vertices[k])) for i, j, k in faces]


def _near(mesh: Mesh, other: Mesh) -> list[Triangle]:
    """Triangles whose boxes meet the box of the other mesh."""
    low, high = other[0].min(axis=0), other[0].max(axis=0)
    corners = mesh[0][mesh[1]]
    kept = ((corners.max(axis=1) >= low) & (corners.min(axis=1) <= high)).all(axis=1)
    return _triangles((mesh[0], mesh[1][kept]))


def _boxes_meet(s: Triangle, t: Triangle) -> bool:
    return all(
        max(p[k] for p in s) >= min(p[k] for p in t) and max(p[k] for p in t) >= min(p[k] for p in s)
        for k in range(3)
    )


def _minus(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _dot(a: Vector, b: Vector) -> Fraction:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _volume(a: Vector, b: Vector, c: Vector, d: Vector) -> Fraction:
    """Six times the signed volume of a tetrahedron."""
    return _dot(_minus(b, a), _cross(_minus(c, a), _minus(d, a)))


def _segment_meets(p: Vector, q: Vector, triangle: Triangle) -> bool:
    a, b, c = triangle
    above, below = _volume(a, b, c, p), _volume(a, b, c, q)
    if above * below > 0:
        return False
    if above == 0 and below == 0:
        return _segment_meets_in_plane(p, q, triangle)
    sides = [_volume(p, q, a, b), _volume(p, q, b, c), _volume(p, q, c, a)]
    return all(side >= 0 for side in sides) or all(side <= 0 for side in sides)


def _segment_meets_in_plane(p: Vector, q: Vector, triangle: Triangle) -> bool:
    normal = _cross(_minus(triangle[1], triangle[0]), _minus(triangle[2], triangle[0]))
    axis = max(range(3), key=lambda k: abs(normal[k]))
    u, v = (k for k in range(3) if k != axis)

    def turn(a: Vector, b: Vector, c: Vector) -> Fraction:
        return (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u])

    def inside(point: Vector) -> bool:
        turns = [turn(triangle[k], triangle[(k + 1) % 3], point) for k in range(3)]
        return all(t >= 0 for t in turns) or all(t <= 0 for t in turns)

    def between(a: Vector, b: Vector, c: Vector) -> bool:
        return all(min(a[k], b[k]) <= c[k] <= max(a[k], b[k]) for k in (u, v))

    def cross(a: Vector, b: Vector, c: Vector, d: Vector) -> bool:
        s, t, m, n = turn(a, b, c), turn(a, b, d), turn(c, d, a), turn(c, d, b)
        if s * t < 0 and m * n < 0:
            return True
        ends = ((s, a, b, c), (t, a, b, d), (m, c, d, a), (n, c, d, b))
        return any(value == 0 and between(e, f, g) for value, e, f, g in ends)

    edges = ((triangle[k], triangle[(k + 1) % 3]) for k in range(3))
    return inside(p) or inside(q) or any(cross(p, q, c, d) for c, d in edges)


def _holds(mesh: Mesh, triangle: Triangle) -> bool:
    """Whether a mesh encloses a triangle that does not meet its surface."""
    draws = random.Random(0)
    triangles = _triangles(mesh)
    while True:
        weights = [Fraction(draws.randint(1, 1000)) for _ in range(3)]
        point = _sum([w / sum(weights) for w in weights], triangle)
        far = _sum([Fraction(1)] * 2, (point, _vector([draws.uniform(-1e3, 1e3) for _ in range(3)])))
        crossings = 0
        for a, b, c in triangles:
            above, below = _volume(a, b, c, point), _volume(a, b, c, far)
            sides = [_volume(point, far, a, b), _volume(point, far, b, c), _volume(point, far, c, a)]
            if above * below == 0 or any(side == 0 for side in sides):
                break
            crossings += above * below < 0 and (all(s > 0 for s in sides) or all(s < 0 for s in sides))
        else:
            return crossings % 2 == 1


def _sum(weights: Sequence[Fraction], points: Sequence[Vector]) -> Vector:
    x, y, z = (sum((w * p[k] for w, p in zip(weights, points, strict=True)), Fraction(0)) for k in range(3))
    return x, y, z
