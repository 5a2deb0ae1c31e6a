"""The depth of two convex sets, of which one is a hull of points: what the compiled part does not compute."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .._arrays import Floats

Support = Callable[[Floats], Floats]
"""The farthest point of a set in a direction."""

_STEPS = 200
_TOLERANCE = 1e-9


def depth(a: Support, b: Support) -> tuple[float, Floats, Floats]:
    """The least translation of A that separates two convex sets with a common point.

    Returns its length, its direction, and a point of A that is deepest inside of B, by the expanding polytope
    algorithm: the boundary of A - B is approached from inside. The length is that of a translation that does separate
    the two, and exceeds the least one by at most 1e-9 of their size, or by what 200 steps leave of round sets.
    """

    def difference(n: Floats) -> tuple[Floats, Floats]:
        point = a(n)
        return point - b(-n), point

    starts = np.array([[x, y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if x or y or z], float)
    starts /= np.linalg.norm(starts, axis=1)[:, None]
    points, of_a = [], []
    reach, direction = np.inf, starts[0]
    for n in starts:
        w, p = difference(n)
        points.append(w)
        of_a.append(p)
        if n @ w < reach:
            reach, direction = float(n @ w), n
    size = float(np.ptp(np.array(points), axis=0).max()) or 1.0
    hull = _Hull(points, size)
    if not hull.faces:
        return max(reach, 0.0), -direction, a(direction)
    for _ in range(_STEPS):
        face = min(hull.faces, key=lambda face: face.offset)
        w, p = difference(face.normal)
        if face.normal @ w < reach:
            reach, direction = float(face.normal @ w), face.normal
        if reach - face.offset <= _TOLERANCE * size or not hull.add(w):
            break
        of_a.append(p)
    # The point of A - B nearest to the origin, in terms of the corners of its face, and so of points of A.
    face = min(hull.faces, key=lambda face: face.offset)
    corners = list(face.corners)
    weights = np.linalg.lstsq(
        np.vstack([np.array([hull.points[i] for i in corners]).T, np.ones(3)]),
        np.append(face.offset * face.normal, 1.0),
        rcond=None,
    )[0].clip(0.0)
    return max(reach, 0.0), -direction, weights @ np.array([of_a[i] for i in corners]) / weights.sum()


class _Face:
    __slots__ = ("corners", "normal", "offset")

    def __init__(self, corners: tuple[int, int, int], normal: Floats, offset: float) -> None:
        self.corners, self.normal, self.offset = corners, normal, offset


class _Hull:
    """The hull of points, one after the other; without faces if they are in a plane."""

    def __init__(self, points: list[Floats], size: float) -> None:
        self.points = [np.asarray(point) for point in points]
        self.slack = 1e-13 * size
        self.faces: list[_Face] = []
        first = self._tetrahedron(size)
        if first is None:
            return
        self.middle = np.mean([self.points[i] for i in first], axis=0)
        for skipped in range(4):
            i, j, k = (first[corner] for corner in range(4) if corner != skipped)
            self._face(i, j, k)
        for i in range(len(points)):
            self._add(i)

    def _tetrahedron(self, size: float) -> tuple[int, int, int, int] | None:
        table = np.array(self.points)
        i = 0
        j = int(np.argmax(np.linalg.norm(table - table[i], axis=1)))
        edge = table[j] - table[i]
        areas = np.linalg.norm(np.cross(table - table[i], edge), axis=1)
        k = int(np.argmax(areas))
        heights = np.abs((table - table[i]) @ np.cross(edge, table[k] - table[i]))
        m = int(np.argmax(heights))
        return None if heights[m] <= 1e-12 * size**3 else (i, j, k, m)

    def _face(self, i: int, j: int, k: int) -> None:
        p, q, r = self.points[i], self.points[j], self.points[k]
        normal = np.cross(q - p, r - p)
        length = float(np.linalg.norm(normal))
        if length == 0.0:
            return
        normal /= length
        if normal @ (p - self.middle) < 0:
            normal, j, k = -normal, k, j
        self.faces.append(_Face((i, j, k), normal, float(normal @ p)))

    def add(self, point: Floats) -> bool:
        """Add a point. Returns whether it is outside."""
        self.points.append(point)
        return self._add(len(self.points) - 1)

    def _add(self, new: int) -> bool:
        point = self.points[new]
        seen = [face for face in self.faces if face.normal @ point > face.offset + self.slack]
        if not seen:
            return False
        edges = {edge for face in seen for edge in _edges(face.corners)}
        gone = {id(face) for face in seen}
        self.faces = [face for face in self.faces if id(face) not in gone]
        for i, j in edges:
            if (j, i) not in edges:
                self._face(i, j, new)
        return True


def _edges(corners: tuple[int, int, int]) -> tuple[tuple[int, int], ...]:
    i, j, k = corners
    return (i, j), (j, k), (k, i)
