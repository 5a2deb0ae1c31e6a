"""The interface of python-fcl over simdop: ``import simdop.fcl as fcl``.

What differs is in the package's README: a manager calls back for pairs that meet, or for the nearest pair, and not for
all pairs whose boxes overlap.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _convex
from ._simdop import Body, Scene, __version__

Floats = NDArray[np.float64]

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


class OBJECT_TYPE:  # noqa: D101
    OT_UNKNOWN, OT_BVH, OT_GEOM, OT_OCTREE, OT_COUNT = range(5)


class NODE_TYPE:  # noqa: D101
    (
        BV_UNKNOWN,
        BV_AABB,
        BV_OBB,
        BV_RSS,
        BV_kIOS,
        BV_OBBRSS,
        BV_KDOP16,
        BV_KDOP18,
        BV_KDOP24,
        GEOM_BOX,
        GEOM_SPHERE,
        GEOM_ELLIPSOID,
        GEOM_CAPSULE,
        GEOM_CONE,
        GEOM_CYLINDER,
        GEOM_CONVEX,
        GEOM_PLANE,
        GEOM_HALFSPACE,
        GEOM_TRIANGLE,
        GEOM_OCTREE,
        NODE_COUNT,
    ) = range(21)


class CCDMotionType:  # noqa: D101
    CCDM_TRANS, CCDM_LINEAR, CCDM_SCREW, CCDM_SPLINE = range(4)


class CCDSolverType:  # noqa: D101
    CCDC_NAIVE, CCDC_CONSERVATIVE_ADVANCEMENT, CCDC_RAY_SHOOTING, CCDC_POLYNOMIAL_SOLVER = range(4)


class GJKSolverType:  # noqa: D101
    GST_LIBCCD, GST_INDEP = range(2)


# ---- Requests and results ------------------------------------------------------------------------


class Contact:
    """Two primitives that meet: ``b1`` and ``b2`` are triangles of meshes, or -1 of shapes."""

    def __init__(self) -> None:
        self.o1: CollisionGeometry | None = None
        self.o2: CollisionGeometry | None = None
        self.b1 = 0
        self.b2 = 0
        self.normal: Floats = np.zeros(3)
        self.pos: Floats = np.zeros(3)
        self.penetration_depth = 0.0


class CostSource:
    """Never filled in."""

    def __init__(self) -> None:
        self.aabb_min: Floats = np.zeros(3)
        self.aabb_max: Floats = np.zeros(3)
        self.cost_density = 0.0
        self.total_cost = 0.0


class CollisionRequest:
    """What ``collide`` returns. Costs and solvers are ignored."""

    def __init__(
        self,
        num_max_contacts: int = 1,
        enable_contact: bool = False,
        num_max_cost_sources: int = 1,
        enable_cost: bool = False,
        use_approximate_cost: bool = True,
        gjk_solver_type: int = GJKSolverType.GST_LIBCCD,
    ) -> None:
        self.num_max_contacts = num_max_contacts
        self.enable_contact = enable_contact
        self.num_max_cost_sources = num_max_cost_sources
        self.enable_cost = enable_cost
        self.use_approximate_cost = use_approximate_cost
        self.gjk_solver_type = gjk_solver_type


class CollisionResult:
    """What ``collide`` has found, added up over its calls."""

    def __init__(self, is_collision: bool = False) -> None:
        self.is_collision = is_collision
        self.contacts: list[Contact] = []
        self.cost_sources: list[CostSource] = []


class ContinuousCollisionRequest:
    """How far a motion may be from contact to count as in contact: ``toc_err``. Solvers are ignored."""

    def __init__(
        self,
        num_max_iterations: int = 10,
        toc_err: float = 0.0001,
        ccd_motion_type: int = CCDMotionType.CCDM_TRANS,
        gjk_solver_type: int = GJKSolverType.GST_LIBCCD,
        ccd_solver_type: int = CCDSolverType.CCDC_CONSERVATIVE_ADVANCEMENT,
    ) -> None:
        self.num_max_iterations = num_max_iterations
        self.toc_err = toc_err
        self.ccd_motion_type = ccd_motion_type
        self.gjk_solver_type = gjk_solver_type
        self.ccd_solver_type = ccd_solver_type


class ContinuousCollisionResult:
    """Whether two motions meet, and when, from 0 to 1."""

    def __init__(self, is_collide: bool = False, time_of_contact: float = 1.0) -> None:
        self.is_collide = is_collide
        self.time_of_contact = time_of_contact


class DistanceRequest:
    """What ``distance`` returns."""

    def __init__(
        self,
        enable_nearest_points: bool = False,
        enable_signed_distance: bool = False,
        gjk_solver_type: int = GJKSolverType.GST_LIBCCD,
    ) -> None:
        self.enable_nearest_points = enable_nearest_points
        self.enable_signed_distance = enable_signed_distance
        self.gjk_solver_type = gjk_solver_type


class DistanceResult:
    """The least distance of several calls, and of which objects."""

    def __init__(self, min_distance_: float = sys.float_info.max) -> None:
        self.min_distance = min_distance_
        self.nearest_points: list[Floats | None] = [None, None]
        self.o1: CollisionGeometry | None = None
        self.o2: CollisionGeometry | None = None
        self.b1 = -1
        self.b2 = -1


class CollisionData:
    """A request and its result, for a manager's callback."""

    def __init__(self, request: CollisionRequest | None = None, result: CollisionResult | None = None) -> None:
        self.request = CollisionRequest() if request is None else request
        self.result = CollisionResult() if result is None else result
        self.done = False


class DistanceData:
    """A request and its result, for a manager's callback."""

    def __init__(self, request: DistanceRequest | None = None, result: DistanceResult | None = None) -> None:
        self.request = DistanceRequest() if request is None else request
        self.result = DistanceResult() if result is None else result
        self.done = False


# ---- Transforms ----------------------------------------------------------------------------------


def _from_quaternion(q: Floats) -> Floats:
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def _to_quaternion(m: Floats) -> Floats:
    # The largest component first, so that its root is not small.
    squares = np.array(
        [
            1 + m[0, 0] + m[1, 1] + m[2, 2],
            1 + m[0, 0] - m[1, 1] - m[2, 2],
            1 - m[0, 0] + m[1, 1] - m[2, 2],
            1 - m[0, 0] - m[1, 1] + m[2, 2],
        ]
    )
    i = int(np.argmax(squares))
    root = math.sqrt(squares[i])
    wx, wy, wz = m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]
    xy, xz, yz = m[0, 1] + m[1, 0], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1]
    rows = [[squares[0], wx, wy, wz], [wx, squares[1], xy, xz], [wy, xy, squares[2], yz], [wz, xz, yz, squares[3]]]
    return np.array(rows[i]) / (2 * root)


class _Posed:
    """A rotation and a translation."""

    _matrix: Floats

    def getRotation(self) -> Floats:
        """The rotation, (3, 3)."""
        return self._matrix[:3, :3].copy()

    def getTranslation(self) -> Floats:
        """The translation, (3,)."""
        return self._matrix[:3, 3].copy()

    def getQuatRotation(self) -> Floats:
        """The rotation as a quaternion w, x, y, z."""
        return _to_quaternion(self._matrix)

    def setRotation(self, R: ArrayLike) -> None:
        """Set the rotation, (3, 3)."""
        self._matrix[:3, :3] = R

    def setTranslation(self, T: ArrayLike) -> None:
        """Set the translation, (3,)."""
        self._matrix[:3, 3] = T

    def setQuatRotation(self, q: ArrayLike) -> None:
        """Set the rotation from a quaternion w, x, y, z."""
        self._matrix[:3, :3] = _from_quaternion(np.asarray(q, float))


class Transform(_Posed):
    """A rigid motion: of nothing, a rotation (matrix or quaternion), a translation, both, or another transform."""

    def __init__(self, *args: Any) -> None:
        self._matrix = np.eye(4)
        if len(args) > 2:
            raise ValueError("Too many arguments to Transform().")
        if len(args) == 1 and isinstance(args[0], Transform):
            self._matrix = args[0]._matrix.copy()
            return
        if len(args) == 2 and np.squeeze(np.asarray(args[1])).shape != (3,):
            raise ValueError("Translation must be (3,).")
        for i, arg in enumerate(args):
            data = np.asarray(arg, float)
            if i == 0 and data.shape == (3, 3):
                self.setRotation(data)
            elif i == 0 and data.shape == (4,):
                self.setQuatRotation(data)
            elif i == len(args) - 1 and (i == 1 or data.shape == (3,)):
                self.setTranslation(data.squeeze())
            else:
                raise ValueError("Invalid input to Transform().")


# ---- Geometries ----------------------------------------------------------------------------------


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
        """Do nothing: bodies have their bounds."""

    def _key(self) -> Any:
        """What the body is made of."""
        raise NotImplementedError(f"simdop.fcl has no queries of {type(self).__name__}")

    def _make(self) -> Body:
        raise NotImplementedError(f"simdop.fcl has no queries of {type(self).__name__}")

    def _body(self) -> Body:
        # Shapes may be changed by their attributes.
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
        """A bound of the points' distances from the origin."""
        return math.sqrt(sum(max(float(n @ self._support(n)), -float(n @ self._support(-n))) ** 2 for n in np.eye(3)))


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
        return max((self.a, self.b, self.c), key=lambda p: float(p @ n))


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


class Capsule(_Round):
    """A capsule along z: ``lz`` is the distance of the centres of its two hemispheres."""

    _NODE = NODE_TYPE.GEOM_CAPSULE

    def _make(self) -> Body:
        return Body.capsule(self.radius, self.lz)

    def _support(self, n: Floats) -> Floats:
        end: Floats = np.array([0.0, 0.0, math.copysign(0.5 * self.lz, n[2])])
        return self.radius * n + end


class Cone(_Round):
    """A cone along z with the middle of its height at the origin and its tip above."""

    _NODE = NODE_TYPE.GEOM_CONE

    def _make(self) -> Body:
        return Body.cone(self.radius, self.lz)

    def _support(self, n: Floats) -> Floats:
        half = np.array([0.0, 0.0, 0.5 * self.lz])
        return max((half, self._rim(n) - half), key=lambda p: float(p @ n))


class Cylinder(_Round):
    """A cylinder along z."""

    _NODE = NODE_TYPE.GEOM_CYLINDER

    def _make(self) -> Body:
        return Body.cylinder(self.radius, self.lz)

    def _support(self, n: Floats) -> Floats:
        end: Floats = np.array([0.0, 0.0, math.copysign(0.5 * self.lz, n[2])])
        return self._rim(n) + end


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


class OcTree(CollisionGeometry):
    """An octree, which has no queries."""

    _NODE = NODE_TYPE.GEOM_OCTREE
    _OBJECT = OBJECT_TYPE.OT_OCTREE

    def __init__(self, r: float, data: bytes) -> None:
        super().__init__()
        self.resolution, self.data = r, data


class Convex(CollisionGeometry):
    """The convex solid that polygons bound: ``faces`` has each one's number of corners before their indices."""

    _NODE = NODE_TYPE.GEOM_CONVEX

    def __init__(self, vertices: ArrayLike, num_faces: int, faces: ArrayLike) -> None:
        super().__init__()
        self.num_faces = int(num_faces)
        self._vertices: Floats = np.array(vertices, float)
        flat = [int(i) for i in np.asarray(faces).ravel()]
        triangles, start = [], 0
        for _ in range(self.num_faces):
            if start >= len(flat) or start + flat[start] >= len(flat):
                raise ValueError("there are fewer faces than num_faces")
            corners = flat[start + 1 : start + 1 + flat[start]]
            triangles += [[corners[0], p, q] for p, q in pairwise(corners[1:])]
            start += 1 + flat[start]
        self._triangles = np.array(triangles, dtype=np.int64).reshape(-1, 3)

    def _key(self) -> Any:
        return None

    def _make(self) -> Body:
        return Body(self._vertices, self._triangles, solid=True, build="fast")

    def _support(self, n: Floats) -> Floats:
        point: Floats = self._vertices[int(np.argmax(self._vertices @ n))]
        return point


class BVHModel(CollisionGeometry):
    """The surface of triangles."""

    _NODE = NODE_TYPE.BV_OBBRSS
    _OBJECT = OBJECT_TYPE.OT_BVH

    def __init__(self) -> None:
        super().__init__()
        self._clear()

    def _clear(self) -> None:
        self._vertices: list[Floats] = []
        self._triangles: list[NDArray[np.int64]] = []
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

    def _mesh(self) -> tuple[Floats, NDArray[np.int64]]:
        vertices = np.concatenate([np.zeros((0, 3)), *self._vertices])
        return vertices, np.concatenate([np.zeros((0, 3), np.int64), *self._triangles])

    def _make(self) -> Body:
        if self._state != 2:
            raise ValueError("BVH geometry is not prepared")
        return Body(*self._mesh(), build="fast")

    def _reach(self) -> float:
        return float(np.linalg.norm(self._mesh()[0], axis=1).max(initial=0.0))


class CollisionObject(_Posed):
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
        return Transform(self.getRotation(), self.getTranslation())

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

    def _support(self, n: Floats) -> Floats:
        """The farthest point in the world."""
        rotation = self._matrix[:3, :3]
        return rotation @ self._geometry._support(n @ rotation) + self._matrix[:3, 3]


# ---- Queries -------------------------------------------------------------------------------------


def _scene(objects: Iterable[CollisionObject]) -> tuple[Scene, dict[int, CollisionObject]]:
    scene, known = Scene(), {}
    for each in objects:
        known[scene.add(each._geometry._body(), each._matrix)] = each
    return scene, known


def _relative(o1: CollisionObject, o2: CollisionObject) -> Floats:
    """The pose of the first in the frame of the second."""
    inverse = o2._matrix[:3, :3].T
    relative = np.eye(4)
    relative[:3, :3] = inverse @ o1._matrix[:3, :3]
    relative[:3, 3] = inverse @ (o1._matrix[:3, 3] - o2._matrix[:3, 3])
    return relative


def _is_mesh(o: CollisionObject) -> bool:
    return isinstance(o._geometry, BVHModel)


def _contact(o1: CollisionObject, o2: CollisionObject, pos: Floats, normal: Floats, depth: float) -> Contact:
    contact = Contact()
    contact.o1, contact.o2 = o1._geometry, o2._geometry
    contact.b1 = contact.b2 = -1
    contact.pos, contact.normal, contact.penetration_depth = pos, normal, depth
    return contact


def _contacts(o1: CollisionObject, o2: CollisionObject, most: int) -> list[Contact]:
    """At least one contact of two objects that meet. Normals point from the first to the second."""
    solid = [isinstance(o._geometry, Convex) for o in (o1, o2)]
    if not any(solid):
        return _contacts_of_primitives(o1, o2, most)
    if isinstance(o1._geometry, Halfspace) or isinstance(o2._geometry, Halfspace):
        return [_contact_of_half_space(o1, o2)]
    if not (_is_mesh(o1) or _is_mesh(o2)):
        depth, direction, deepest = _convex.depth(o1._support, o2._support)
        return [_contact(o1, o2, deepest + 0.5 * depth * direction, -direction, depth)]
    # Of a convex solid and the triangles of a mesh: those that may reach into it.
    convex, mesh, is_first = (o1, o2, True) if solid[0] else (o2, o1, False)
    vertices, triangles = mesh._geometry._mesh()  # type: ignore[attr-defined]
    body, world = convex._geometry._body(), vertices @ mesh._matrix[:3, :3].T + mesh._matrix[:3, 3]
    inverse = _relative(CollisionObject(mesh._geometry), convex)
    contacts: list[Contact] = []
    for index, corners in enumerate(world[triangles]):
        if len(contacts) == most:
            break
        if not Body.triangle(corners).collide(body, inverse):
            continue
        triangle = CollisionObject(TriangleP(*corners))
        pair = (convex, triangle) if is_first else (triangle, convex)
        depth, direction, deepest = _convex.depth(pair[0]._support, pair[1]._support)
        contact = _contact(o1, o2, deepest + 0.5 * depth * direction, -direction, depth)
        contact.b1, contact.b2 = (-1, index) if is_first else (index, -1)
        contacts.append(contact)
    return contacts


def _contact_of_half_space(o1: CollisionObject, o2: CollisionObject) -> Contact:
    """The contact of a half-space and a convex solid."""
    is_first = isinstance(o1._geometry, Halfspace)
    half_space, solid = (o1, o2) if is_first else (o2, o1)
    geometry = half_space._geometry
    assert isinstance(geometry, Halfspace)
    outwards = half_space._matrix[:3, :3] @ geometry.n
    deepest = solid._support(-outwards)
    depth = geometry.d + float(outwards @ half_space._matrix[:3, 3]) - float(outwards @ deepest)
    return _contact(o1, o2, deepest + 0.5 * depth * outwards, outwards if is_first else -outwards, depth)


def _contacts_of_primitives(o1: CollisionObject, o2: CollisionObject, most: int) -> list[Contact]:
    found = o1._geometry._body().contacts(o2._geometry._body(), _relative(o1, o2), limit=most)
    rotation, shift = o2._matrix[:3, :3], o2._matrix[:3, 3]
    contacts = []
    rows = zip(found.index_a, found.index_b, found.points, found.normals, found.depths, strict=True)
    for a, b, point, normal, depth in rows:
        contact = _contact(o1, o2, rotation @ point + shift, -(rotation @ normal), float(depth))
        contact.b1 = int(a) if _is_mesh(o1) else -1
        contact.b2 = int(b) if _is_mesh(o2) else -1
        contacts.append(contact)
    return contacts


def collide(
    o1: CollisionObject,
    o2: CollisionObject,
    request: CollisionRequest | None = None,
    result: CollisionResult | None = None,
) -> int:
    """Find contacts of two objects, at most ``num_max_contacts``; return their number."""
    request = CollisionRequest() if request is None else request
    result = CollisionResult() if result is None else result
    scene, _ = _scene((o1, o2))
    if not scene.collide():
        return 0
    result.is_collision = True
    if request.num_max_contacts <= 0:
        return 0
    if request.enable_contact:
        contacts = _contacts(o1, o2, request.num_max_contacts)
    else:
        contacts = [_contact(o1, o2, np.zeros(3), np.zeros(3), 0.0)]
    result.contacts += contacts
    return len(contacts)


def _overlap(o1: CollisionObject, o2: CollisionObject, is_signed: bool) -> tuple[float, list[Floats | None], int, int]:
    """What ``distance`` tells of two objects that meet."""
    if _is_mesh(o1) and _is_mesh(o2):
        contacts = _contacts(o1, o2, 1)
        first = contacts[0] if contacts else _contact(o1, o2, np.zeros(3), np.zeros(3), 0.0)
        return 0.0, [first.pos, first.pos], first.b1, first.b2
    if not is_signed:
        return -1.0, [np.zeros(3), np.zeros(3)], -1, -1
    contacts = _contacts(o1, o2, sys.maxsize)
    deepest = max(contacts, key=lambda contact: contact.penetration_depth)
    half = 0.5 * deepest.penetration_depth * deepest.normal
    return -deepest.penetration_depth, [deepest.pos + half, deepest.pos - half], deepest.b1, deepest.b2


def distance(
    o1: CollisionObject,
    o2: CollisionObject,
    request: DistanceRequest | None = None,
    result: DistanceResult | None = None,
) -> float:
    """The distance of two objects.

    Of objects that meet it is 0 for two meshes; for others, less their depth if ``enable_signed_distance``, else -1.
    """
    request = DistanceRequest() if request is None else request
    result = DistanceResult() if result is None else result
    scene, known = _scene((o1, o2))
    near = scene.clearance()
    points: list[Floats | None] = [None, None]
    b1 = b2 = -1
    if near.upper == 0.0:
        least, points, b1, b2 = _overlap(o1, o2, request.enable_signed_distance)
    else:
        least = near.upper
        if near.bodies is not None and near.points is not None and near.indices is not None:
            first = 0 if known[near.bodies[0]] is o1 else 1
            points = [near.points[first], near.points[1 - first]]
            b1 = near.indices[first] if _is_mesh(o1) else -1
            b2 = near.indices[1 - first] if _is_mesh(o2) else -1
    if least < result.min_distance:
        result.min_distance = least
        result.nearest_points = points
        result.o1, result.o2 = o1._geometry, o2._geometry
        result.b1, result.b2 = b1, b2
    return least


def _angle(rotation: Floats) -> float:
    q = _to_quaternion(rotation)
    return 2.0 * math.atan2(float(np.linalg.norm(q[1:])), abs(float(q[0])))


def _at(start: Floats, end: Floats, time: float, motion: int) -> Floats:
    """A pose of a motion. The rotation of a translation stays; of others it turns about one axis."""
    pose = start.copy()
    pose[:3, 3] = (1 - time) * start[:3, 3] + time * end[:3, 3]
    if motion != CCDMotionType.CCDM_TRANS:
        q = _to_quaternion(end[:3, :3] @ start[:3, :3].T)
        axis, half = q[1:], math.atan2(float(np.linalg.norm(q[1:])), float(q[0])) * time
        if np.any(axis):
            turn = np.concatenate([[math.cos(half)], math.sin(half) * axis / np.linalg.norm(axis)])
            pose[:3, :3] = _from_quaternion(turn) @ start[:3, :3]
    return pose


def continuousCollide(
    o1: CollisionObject,
    tf1_end: Transform,
    o2: CollisionObject,
    tf2_end: Transform,
    request: ContinuousCollisionRequest | None = None,
    result: ContinuousCollisionResult | None = None,
) -> float:
    """The first time from 0 to 1 at which two objects meet that move to other poses; 1 if none.

    By conservative advancement: no contact is missed. Steps end at a distance of ``toc_err`` times the motion's length,
    or after a thousand. All motions but translations are linear ones, with a rotation about one axis.
    """
    request = ContinuousCollisionRequest() if request is None else request
    result = ContinuousCollisionResult() if result is None else result
    motion = request.ccd_motion_type
    ends = tf1_end._matrix, tf2_end._matrix
    starts = o1._matrix, o2._matrix
    moves = [end[:3, 3] - start[:3, 3] for start, end in zip(starts, ends, strict=True)]
    speed = float(np.linalg.norm(moves[0] - moves[1]))
    if motion != CCDMotionType.CCDM_TRANS:
        for o, start, end in zip((o1, o2), starts, ends, strict=True):
            speed += _angle(end[:3, :3] @ start[:3, :3].T) * o._geometry._reach()
    time, steps = 0.0, 0
    while True:
        at = [
            CollisionObject(o._geometry, Transform(pose[:3, :3], pose[:3, 3]))
            for o, start, end in zip((o1, o2), starts, ends, strict=True)
            for pose in [_at(start, end, time, motion)]
        ]
        gap = _scene(at)[0].clearance().lower
        steps += 1
        if gap <= request.toc_err * speed or steps == 1000:
            result.is_collide = True
            result.time_of_contact = min(result.time_of_contact, time)
            return time
        if speed == 0.0 or gap >= speed * (1.0 - time):
            return 1.0
        time += gap / speed


def defaultCollisionCallback(o1: CollisionObject, o2: CollisionObject, cdata: CollisionData) -> bool:
    """Collide two objects; true when there are enough contacts."""
    if cdata.done:
        return True
    request, result = cdata.request, cdata.result
    collide(o1, o2, request, result)
    if not request.enable_cost and result.is_collision and len(result.contacts) > request.num_max_contacts:
        cdata.done = True
    return cdata.done


def defaultDistanceCallback(o1: CollisionObject, o2: CollisionObject, cdata: DistanceData) -> tuple[bool, float]:
    """Keep the least distance."""
    if cdata.done:
        return True, cdata.result.min_distance
    distance(o1, o2, cdata.request, cdata.result)
    least = cdata.result.min_distance
    return (True, least) if least <= 0 else (cdata.done, least)


_CollisionCallback = Callable[[CollisionObject, CollisionObject, Any], Any]
_DistanceCallback = Callable[[CollisionObject, CollisionObject, Any], Any]


class DynamicAABBTreeCollisionManager:
    """Objects that are tested together."""

    def __init__(self) -> None:
        self.max_tree_nonbalanced_level = 10
        self.tree_incremental_balance_pass = 10
        self.tree_topdown_balance_threshold = 2
        self.tree_topdown_level = 0
        self.tree_init_level = 0
        self.octree_as_geometry_collide = True
        self.octree_as_geometry_distance = False
        self.clear()

    def clear(self) -> None:
        """Remove all objects."""
        self._scene = Scene()
        self._numbers: dict[int, int] = {}
        self._known: dict[int, CollisionObject] = {}

    def registerObjects(self, other_objs: Iterable[CollisionObject]) -> None:
        """Add objects."""
        for obj in other_objs:
            self.registerObject(obj)

    def registerObject(self, obj: CollisionObject) -> None:
        """Add an object."""
        number = self._scene.add(obj._geometry._body(), obj._matrix)
        self._numbers[id(obj)] = number
        self._known[number] = obj

    def unregisterObject(self, obj: CollisionObject) -> None:
        """Remove an object, if it is there."""
        number = self._numbers.pop(id(obj), None)
        if number is not None:
            self._scene.remove(number)
            del self._known[number]

    def setup(self) -> None:
        """Do nothing: objects are ready when they are added."""

    def update(self, arg: Any = None) -> None:
        """Take over the poses of one object, of several, or of all."""
        objects = self._known.values() if arg is None else arg if hasattr(arg, "__len__") else [arg]
        for obj in objects:
            number = self._numbers.get(id(obj))
            if number is not None:
                self._scene.move(number, obj._matrix)

    def getObjects(self) -> list[CollisionObject]:
        """All objects."""
        return list(self._known.values())

    def empty(self) -> bool:
        """Whether there is none."""
        return not self._known

    def size(self) -> int:
        """Number of objects."""
        return len(self._known)

    def _other(self, other: Any) -> tuple[Scene, dict[int, CollisionObject]]:
        return (other._scene, other._known) if isinstance(other, type(self)) else _scene([other])

    def _arguments(self, args: tuple[Any, ...]) -> tuple[Any, Any, Any]:
        if len(args) == 2 and callable(args[1]):
            return None, *args
        if len(args) == 3 and callable(args[2]):
            return args
        raise ValueError("expected (data, callback), or an object or a manager before them")

    def collide(self, *args: Any) -> None:
        """Call back for all pairs that meet, until it returns true: (data, callback), (object or manager, ...)."""
        other, data, callback = self._arguments(args)
        if other is None:
            known, pairs = self._known, self._scene.pairs()
        else:
            scene, known = self._other(other)
            pairs = self._scene.pairs(other=scene)
        for a, b in pairs:
            if callback(self._known[a], known[b], data):
                break

    def distance(self, *args: Any) -> None:
        """Call back for the nearest pair: (data, callback), (object or manager, data, callback)."""
        other, data, callback = self._arguments(args)
        scene, known = (None, self._known) if other is None else self._other(other)
        nearest = self._scene.clearance(other=scene)
        if nearest.upper > 0.0:
            pairs = [] if nearest.bodies is None else [nearest.bodies]
        else:
            # Of those that meet, the deepest.
            pairs = self._scene.pairs(other=scene)
        for a, b in pairs:
            callback(self._known[a], known[b], data)
