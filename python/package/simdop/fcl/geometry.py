"""The base of all geometries."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np

from .._arrays import Floats
from .._simdop import Body
from .enumerations import OBJECT_TYPE


class CollisionGeometry:
    """A geometry, which becomes a body when it is first used."""

    _NODE: ClassVar[int | None] = None
    _OBJECT: ClassVar[int] = OBJECT_TYPE.OT_GEOM

    def __init__(self) -> None:
        self.aabb_center: Floats | None = None

    def getNodeType(self) -> int | None:
        """A number of NODE_TYPE."""
        return self._NODE

    def computeLocalAABB(self) -> None:
        """Do nothing: bodies always have bounds."""

    def _key(self) -> Any:
        """The attributes that define the body, if they may change."""
        return None

    def _make(self) -> Body:
        raise NotImplementedError(f"simdop.fcl has no queries of {type(self).__name__}")

    def _body(self) -> Body:
        # Users may change the attributes of shapes.
        key = self._key()
        made: tuple[Any, Body] | None = getattr(self, "_made", None)
        if made is None or made[0] != key:
            made = (key, self._make())
            self._made = made
        return made[1]

    def _support(self, n: Floats) -> Floats:
        """The farthest point in a direction of length 1."""
        raise NotImplementedError(f"simdop.fcl has no penetration depth of {type(self).__name__}")

    def _reach(self) -> float:
        """An upper bound on the distance of any point from the origin."""
        return math.sqrt(sum(max(float(n @ self._support(n)), -float(n @ self._support(-n))) ** 2 for n in np.eye(3)))
