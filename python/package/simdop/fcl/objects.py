"""Geometries at poses in the world."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from .._arrays import Floats
from .._simdop import Scene
from .geometry import CollisionGeometry
from .models import BVHModel
from .transforms import Posed, Transform


class CollisionObject(Posed):
    """A geometry at a pose in the world."""

    def __init__(self, geom: CollisionGeometry | None = None, tf: Transform | None = None) -> None:
        if geom is None or geom.getNodeType() is None:
            raise ValueError("a collision object needs a geometry")
        self._geometry = geom
        self._matrix = np.eye(4) if tf is None else tf._matrix.copy()

    @property
    def collision_geometry(self) -> CollisionGeometry:
        """The geometry."""
        return self._geometry

    def getObjectType(self) -> int:
        """A number of OBJECT_TYPE."""
        return self._geometry._OBJECT

    def getNodeType(self) -> int | None:
        """A number of NODE_TYPE."""
        return self._geometry.getNodeType()

    def getTransform(self) -> Transform:
        """The pose."""
        return Transform._from_matrix(self._matrix)

    def setTransform(self, tf: Transform) -> None:
        """Set the pose."""
        self._matrix = tf._matrix.copy()

    def isOccupied(self) -> bool:
        """Always true."""
        return True

    def isFree(self) -> bool:
        """Always false."""
        return False

    def isUncertain(self) -> bool:
        """Always false."""
        return False

    def _add_to(self, scene: Scene) -> int:
        """Add the body to a scene; return its number there."""
        return scene.add(self._geometry._body(), self._matrix)

    def _is_mesh(self) -> bool:
        return isinstance(self._geometry, BVHModel)

    def _triangle(self, index: int) -> int:
        """The index of a primitive if it is a mesh's triangle; -1 for a shape."""
        return int(index) if self._is_mesh() else -1


def scene_of(objects: Iterable[CollisionObject]) -> tuple[Scene, dict[int, CollisionObject]]:
    """A scene of objects, and the objects by number."""
    scene, known = Scene(), {}
    for each in objects:
        known[each._add_to(scene)] = each
    return scene, known


def relative(o1: CollisionObject, o2: CollisionObject) -> Floats:
    """The pose of the first in the frame of the second."""
    inverse = o2._matrix[:3, :3].T
    pose = np.eye(4)
    pose[:3, :3] = inverse @ o1._matrix[:3, :3]
    pose[:3, 3] = inverse @ (o1._matrix[:3, 3] - o2._matrix[:3, 3])
    return pose
