"""The interface of python-fcl over simdop: ``import simdop.fcl as fcl``.

The package's README lists the differences: a manager calls back for pairs that meet, or for the nearest pair, not for
all pairs whose boxes overlap.
"""

from .._simdop import __version__
from .continuous import continuousCollide
from .enumerations import NODE_TYPE, OBJECT_TYPE, CCDMotionType, CCDSolverType, GJKSolverType
from .geometry import CollisionGeometry
from .managers import DynamicAABBTreeCollisionManager, defaultCollisionCallback, defaultDistanceCallback
from .models import BVHModel, OcTree
from .objects import CollisionObject
from .queries import collide, distance
from .requests import (
    CollisionData,
    CollisionRequest,
    CollisionResult,
    Contact,
    ContinuousCollisionRequest,
    ContinuousCollisionResult,
    CostSource,
    DistanceData,
    DistanceRequest,
    DistanceResult,
)
from .shapes import Box, Capsule, Cone, Convex, Cylinder, Ellipsoid, Halfspace, Plane, Sphere, TriangleP
from .transforms import Transform

__all__ = [
    "NODE_TYPE",
    "OBJECT_TYPE",
    "BVHModel",
    "Box",
    "CCDMotionType",
    "CCDSolverType",
    "Capsule",
    "CollisionData",
    "CollisionGeometry",
    "CollisionObject",
    "CollisionRequest",
    "CollisionResult",
    "Cone",
    "Contact",
    "ContinuousCollisionRequest",
    "ContinuousCollisionResult",
    "Convex",
    "CostSource",
    "Cylinder",
    "DistanceData",
    "DistanceRequest",
    "DistanceResult",
    "DynamicAABBTreeCollisionManager",
    "Ellipsoid",
    "GJKSolverType",
    "Halfspace",
    "OcTree",
    "Plane",
    "Sphere",
    "Transform",
    "TriangleP",
    "__version__",
    "collide",
    "continuousCollide",
    "defaultCollisionCallback",
    "defaultDistanceCallback",
    "distance",
]
