"""Answers that share no code with the library: exact rational arithmetic, and loops over all pairs."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import product

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Mesh = tuple[Floats, NDArray[np.int64]]
Point = tuple[Fraction, Fraction, Fraction]


def moved(points: Floats, pose: Floats) -> Floats:
    """Points at a pose, each coordinate as ((r0 x + r1 y) + r2 z) + t: verdicts are exact for these corners."""
    x, y, z = points.T
    rows = [((row[0] * x + row[1] * y) + row[2] * z) + row[3] for row in pose[:3]]
    return np.stack(rows, axis=-1)


def _exact(p: Floats) -> Point:
    return Fraction(float(p[0])), Fraction(float(p[1])), Fraction(float(p[2]))


def _minus(p: Point, q: Point) -> Point:
    return p[0] - q[0], p[1] - q[1], p[2] - q[2]


def _cross(p: Point, q: Point) -> Point:
    return p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]


def _dot(p: Point, q: Point) -> Fraction:
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]


def triangles_meet(a: Floats, b: Floats) -> bool:
    """Whether two triangles, (3, 3) each, have a common point: exactly, by separating axes."""
    p, q = [_exact(corner) for corner in a], [_exact(corner) for corner in b]
    edges_p = [_minus(p[(i + 1) % 3], p[i]) for i in range(3)]
    edges_q = [_minus(q[(i + 1) % 3], q[i]) for i in range(3)]
    normals = [_cross(edges_p[0], edges_p[1]), _cross(edges_q[0], edges_q[1])]
    # In a common plane, the edges' normals within it separate; for degenerate triangles, the edges themselves may.
    axes = [*normals, *edges_p, *edges_q]
    axes += [_cross(e, f) for e, f in product(edges_p, edges_q)]
    axes += [_cross(n, e) for n in normals for e in (*edges_p, *edges_q)]
    for axis in axes:
        along_p, along_q = [_dot(axis, c) for c in p], [_dot(axis, c) for c in q]
        if max(along_p) < min(along_q) or max(along_q) < min(along_p):
            return False
    return True


def meeting_pairs(a: Mesh, b: Mesh, pose: Floats) -> set[tuple[int, int]]:
    """All pairs of triangles of two meshes that meet, with A at a pose."""
    corners_a, corners_b = moved(a[0], pose)[a[1]], b[0][b[1]]
    found = set()
    for i, p in enumerate(corners_a):
        for j, q in enumerate(corners_b):
            # This test of boxes is exact, too.
            if (p.max(0) < q.min(0)).any() or (q.max(0) < p.min(0)).any():
                continue
            if triangles_meet(p, q):
                found.add((i, j))
    return found


def _point_triangle(p: Floats, t: Floats) -> float:
    """The distance of a point from a triangle with area."""
    a, b, c = t
    u, v, w = b - a, c - a, p - a
    normal = np.cross(u, v)
    square = float(normal @ normal)
    s, r = float(np.cross(w, v) @ normal) / square, float(np.cross(u, w) @ normal) / square
    if s >= 0 and r >= 0 and s + r <= 1:
        return abs(float(w @ normal)) / float(np.sqrt(square))
    return min(_point_segment(p, a, b), _point_segment(p, b, c), _point_segment(p, c, a))


def _point_segment(p: Floats, a: Floats, b: Floats) -> float:
    edge = b - a
    t = min(max(float((p - a) @ edge) / float(edge @ edge), 0.0), 1.0)
    return float(np.linalg.norm(p - a - t * edge))


def _segments(a: Floats, b: Floats, c: Floats, d: Floats) -> float:
    u, v, w = b - a, d - c, a - c
    normal = np.cross(u, v)
    square = float(normal @ normal)
    if square > 0:
        s = float(np.cross(-w, v) @ normal) / square
        t = float(np.cross(-w, u) @ normal) / square
        if 0 <= s <= 1 and 0 <= t <= 1:
            return abs(float(w @ normal)) / float(np.sqrt(square))
    return min(_point_segment(a, c, d), _point_segment(b, c, d), _point_segment(c, a, b), _point_segment(d, a, b))


def triangle_distance(a: Floats, b: Floats) -> float:
    """The distance of two triangles that do not meet, up to rounding."""
    corners = [_point_triangle(p, b) for p in a] + [_point_triangle(q, a) for q in b]
    edges = [_segments(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]) for i in range(3) for j in range(3)]
    return min(corners + edges)


def mesh_distance(a: Mesh, b: Mesh, pose: Floats) -> float:
    """The distance of two surfaces that do not meet."""
    corners_a, corners_b = moved(a[0], pose)[a[1]], b[0][b[1]]
    return min(triangle_distance(p, q) for p in corners_a for q in corners_b)


def neighbours(points: NDArray[np.float32], query: NDArray[np.float32], radius: float) -> Sequence[int]:
    """The points within a radius of a query, with every operation rounded to single precision."""
    d = points - query
    squares = (d[:, 0] * d[:, 0] + d[:, 1] * d[:, 1]) + d[:, 2] * d[:, 2]
    r = np.float32(radius)
    return [int(i) for i in np.flatnonzero(squares <= r * r)]


def nearest(points: NDArray[np.float32], query: NDArray[np.float32], k: int) -> Sequence[int]:
    """The k nearest points; among equally near ones, those with the lowest indices."""
    d = points - query
    squares = (d[:, 0] * d[:, 0] + d[:, 1] * d[:, 1]) + d[:, 2] * d[:, 2]
    return [int(i) for i in np.argsort(squares, kind="stable")[:k]]
