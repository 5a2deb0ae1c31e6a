"""Shapes by their dimensions, and convex solids."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._arrays import Floats
from .._simdop import Body
from .enumerations import NODE_TYPE
from .geometry import CollisionGeometry


def _farthest(points: Iterable[Floats], n: Floats) -> Floats:
    return max(points, key=lambda p: float(p @ n))


class TriangleP(CollisionGeometry):
    """A triangle."""

    _NODE = NODE_TYPE.GEOM_TRIANGLE

    def __init__(self, a: ArrayLike, b: ArrayLike, c: ArrayLike) -> None:
        super().__init__()
        self.a, self.b, self.c = (np.array(corner, float) for corner in (a, b, c))

    def _key(self) -> Any:
        return np.array([self.a, self.b, self.c]).tobytes()

    def _make(self) -> Body:
        return Body.triangle([self.a, self.b, self.c])

    def _support(self, n: Floats) -> Floats:
        return _farthest((self.a, self.b, self.c), n)


class Box(CollisionGeometry):
    """A box about the origin, by its side lengths."""

    _NODE = NODE_TYPE.GEOM_BOX

    def __init__(self, x: float, y: float, z: float) -> None:
        super().__init__()
        self.side: Floats = np.array([x, y, z], float)

    def _key(self) -> Any:
        return tuple(self.side)

    def _make(self) -> Body:
        return Body.box(self.side)

    def _support(self, n: Floats) -> Floats:
        return np.copysign(0.5 * self.side, n)


class Sphere(CollisionGeometry):
    """A ball about the origin."""

    _NODE = NODE_TYPE.GEOM_SPHERE

    def __init__(self, radius: float) -> None:
        super().__init__()
        self.radius = float(radius)

    def _key(self) -> Any:
        return self.radius

    def _make(self) -> Body:
        return Body.sphere(self.radius)

    def _support(self, n: Floats) -> Floats:
        return self.radius * n


class Ellipsoid(CollisionGeometry):
    """An ellipsoid, which has no queries."""

    _NODE = NODE_TYPE.GEOM_ELLIPSOID

    def __init__(self, a: float, b: float, c: float) -> None:
        super().__init__()
        self.radii: Floats = np.array([a, b, c], float)


class _Round(CollisionGeometry):
    """A shape with a radius and a height along z."""

    def __init__(self, radius: float, lz: float) -> None:
        super().__init__()
        self.radius, self.lz = float(radius), float(lz)

    def _key(self) -> Any:
        return self.radius, self.lz

    def _rim(self, n: Floats) -> Floats:
        """The farthest point of the disc about the origin."""
        flat = math.hypot(n[0], n[1])
        return np.array([self.radius * n[0] / flat, self.radius * n[1] / flat, 0.0]) if flat > 0 else np.zeros(3)

    def _end(self, n: Floats) -> Floats:
        """The farther end of the axis."""
        return np.array([0.0, 0.0, math.copysign(0.5 * self.lz, n[2])])


class Capsule(_Round):
    """A capsule along z: ``lz`` is the distance between the centres of its two hemispheres."""

    _NODE = NODE_TYPE.GEOM_CAPSULE

    def _make(self) -> Body:
        return Body.capsule(self.radius, self.lz)

    def _support(self, n: Floats) -> Floats:
        return self.radius * n + self._end(n)


class Cone(_Round):
    """A cone along z with the middle of its height at the origin and its tip above."""

    _NODE = NODE_TYPE.GEOM_CONE

    def _make(self) -> Body:
        return Body.cone(self.radius, self.lz)

    def _support(self, n: Floats) -> Floats:
        half = np.array([0.0, 0.0, 0.5 * self.lz])
        return _farthest((half, self._rim(n) - half), n)


class Cylinder(_Round):
    """A cylinder along z."""

    _NODE = NODE_TYPE.GEOM_CYLINDER

    def _make(self) -> Body:
        return Body.cylinder(self.radius, self.lz)

    def _support(self, n: Floats) -> Floats:
        return self._rim(n) + self._end(n)


class Halfspace(CollisionGeometry):
    """All points p with n . p <= d."""

    _NODE = NODE_TYPE.GEOM_HALFSPACE

    def __init__(self, n: ArrayLike, d: float) -> None:
        super().__init__()
        self.n: Floats = np.array(n, float)
        self.d = float(d)
        length = float(np.linalg.norm(self.n))
        if length > 0:
            self.n /= length
            self.d /= length

    def _key(self) -> Any:
        return (*self.n, self.d)

    def _make(self) -> Body:
        return Body.half_space(self.n, self.d)


class Plane(Halfspace):
    """A plane, which has no queries."""

    _NODE = NODE_TYPE.GEOM_PLANE

    def _make(self) -> Body:
        raise NotImplementedError("simdop.fcl has no queries of Plane: use Halfspace")


class Convex(CollisionGeometry):
    """The hull of vertices; ``faces``, for each polygon its number of corners and their indices, are only checked."""

    _NODE = NODE_TYPE.GEOM_CONVEX

    def __init__(self, vertices: ArrayLike, num_faces: int, faces: ArrayLike) -> None:
        super().__init__()
        self.num_faces = int(num_faces)
        self._vertices: Floats = np.array(vertices, float)
        flat = [int(i) for i in np.asarray(faces).ravel()]
        start = 0
        for _ in range(self.num_faces):
            if start >= len(flat) or start + flat[start] >= len(flat):
                raise ValueError("there are fewer faces than num_faces")
            start += 1 + flat[start]

    def _make(self) -> Body:
        return Body.hull(self._vertices)

    def _support(self, n: Floats) -> Floats:
        point: Floats = self._vertices[int(np.argmax(self._vertices @ n))]
        return point
