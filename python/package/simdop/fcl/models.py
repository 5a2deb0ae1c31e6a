"""Meshes and octrees."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._arrays import Floats, Triangles
from .._simdop import Body
from .enumerations import NODE_TYPE, OBJECT_TYPE
from .geometry import CollisionGeometry


class BVHModel(CollisionGeometry):
    """The surface of triangles."""

    _NODE = NODE_TYPE.BV_OBBRSS
    _OBJECT = OBJECT_TYPE.OT_BVH

    def __init__(self) -> None:
        super().__init__()
        self._clear()

    def _clear(self) -> None:
        self._vertices: list[Floats] = []
        self._triangles: list[Triangles] = []
        self._state = 0

    def num_tries_(self) -> int:
        """Number of triangles."""
        return sum(len(triangles) for triangles in self._triangles)

    def buildState(self) -> int:
        """0 if empty, 1 after ``beginModel``, 2 after ``endModel``."""
        return self._state

    def beginModel(self, num_tris_: int = 0, num_vertices_: int = 0) -> int:
        """Begin with an empty mesh."""
        self._clear()
        self._state = 1
        return 0

    def _count(self) -> int:
        return sum(len(vertices) for vertices in self._vertices)

    def _check_open(self) -> None:
        if self._state != 1:
            raise ValueError("BVH construction does not follow correct sequence")

    def addVertex(self, x: float, y: float, z: float) -> bool:
        """Add a vertex."""
        self._check_open()
        self._vertices.append(np.array([[x, y, z]], float))
        return True

    def addTriangle(self, v1: ArrayLike, v2: ArrayLike, v3: ArrayLike) -> bool:
        """Add a triangle by its corners."""
        return self.addSubModel(np.array([v1, v2, v3], float), [[0, 1, 2]])

    def addSubModel(self, verts: ArrayLike, triangles: ArrayLike) -> bool:
        """Add vertices (n, 3), and triangles (m, 3) of their indices."""
        self._check_open()
        first = self._count()
        self._vertices.append(np.array(verts, float).reshape(-1, 3))
        self._triangles.append(np.array(triangles, dtype=np.int64).reshape(-1, 3) + first)
        return True

    def endModel(self) -> int:
        """Build the tree."""
        self._check_open()
        self._state = 2
        self._body()
        return 0

    def _key(self) -> Any:
        return self._state

    def _mesh(self) -> tuple[Floats, Triangles]:
        vertices = np.concatenate([np.zeros((0, 3)), *self._vertices])
        return vertices, np.concatenate([np.zeros((0, 3), np.int64), *self._triangles])

    def _make(self) -> Body:
        if self._state != 2:
            raise ValueError("BVH geometry is not prepared")
        return Body(*self._mesh(), build="fast")

    def _reach(self) -> float:
        return float(np.linalg.norm(self._mesh()[0], axis=1).max(initial=0.0))


class OcTree(CollisionGeometry):
    """An octree, which has no queries."""

    _NODE = NODE_TYPE.GEOM_OCTREE
    _OBJECT = OBJECT_TYPE.OT_OCTREE

    def __init__(self, r: float, data: bytes) -> None:
        super().__init__()
        self.resolution, self.data = r, data
