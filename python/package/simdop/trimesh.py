"""A ``CollisionManager`` for trimesh, with the methods and results of ``trimesh.collision.CollisionManager``.

As in trimesh, convex meshes are solids and others surfaces. Transforms that scale or mirror change the vertices.
"""

from __future__ import annotations

from typing import Any
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import ArrayLike

from . import fcl
from ._arrays import Floats, Triangles
from ._simdop import Body, Scene
from .fcl.managers import nearest_pairs

__all__ = ["CollisionManager", "ContactData", "DistanceData", "mesh_to_BVH", "mesh_to_convex", "scene_to_collision"]

_CONTACTS_PER_PAIR = 100_000
_EXTERNAL = "__external"
_RIGID = 1e-5
"""How much the matrix of a pose in a scene may deviate from a rotation."""


class ContactData:
    """A contact of two objects."""

    def __init__(self, names: tuple[Any, Any], contact: fcl.Contact) -> None:
        self.names = set(names)
        self._inds = {names[0]: contact.b1, names[1]: contact.b2}
        self._contact = contact

    @property
    def normal(self) -> Floats:
        """The direction from the first object to the second that separates them, (3,)."""
        return self._contact.normal

    @property
    def point(self) -> Floats:
        """The point of contact, (3,)."""
        return self._contact.pos

    @property
    def depth(self) -> float:
        """The penetration depth."""
        return self._contact.penetration_depth

    def index(self, name: Any) -> int:
        """The face of the mesh with this name; -1 for a convex mesh."""
        return self._inds[name]


class DistanceData:
    """The distance of two objects."""

    def __init__(self, names: tuple[Any, Any], result: fcl.DistanceResult) -> None:
        self.names = set(names)
        self._inds = {names[0]: result.b1, names[1]: result.b2}
        self._points = {names[0]: result.nearest_points[0], names[1]: result.nearest_points[1]}
        self._distance = result.min_distance

    @property
    def distance(self) -> float:
        """The distance; for convex meshes that meet, minus their depth."""
        return self._distance

    def index(self, name: Any) -> int:
        """The closest face of the mesh with this name; -1 for a convex mesh."""
        return self._inds[name]

    def point(self, name: Any) -> Floats | None:
        """The closest point of the mesh with this name, (3,)."""
        return self._points[name]


class _Convex(fcl.Convex):
    """A convex mesh, which shares its body with meshes of the same vertices and faces."""

    def __init__(self, mesh: Any) -> None:
        vertices, faces = np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int64)
        super().__init__(vertices, 0, [])
        self.num_faces, self._triangles = len(faces), faces

    def _make(self) -> Body:
        return _shared(self._vertices, self._triangles, True)


class _Surface(fcl.BVHModel):
    """A mesh, which shares its body with meshes of the same vertices and faces."""

    def __init__(self, mesh: Any) -> None:
        super().__init__()
        self._vertices = [np.asarray(mesh.vertices, float)]
        self._triangles = [np.asarray(mesh.faces, np.int64)]
        self._state = 2

    def _make(self) -> Body:
        return _shared(*self._mesh(), False)


_bodies: WeakValueDictionary[tuple[bytes, bytes, bool], Body] = WeakValueDictionary()


def _shared(vertices: Floats, triangles: Triangles, convex: bool) -> Body:
    key = (vertices.tobytes(), triangles.tobytes(), convex)
    body = _bodies.get(key)
    if body is None:
        body = Body.hull(vertices) if convex else Body(vertices, triangles, build="fast")
        _bodies[key] = body
    return body


def mesh_to_BVH(mesh: Any) -> fcl.BVHModel:  # noqa: N802
    """The surface of a mesh."""
    return _Surface(mesh)


def mesh_to_convex(mesh: Any) -> fcl.Convex:
    """The solid of a convex mesh."""
    return _Convex(mesh)


def _as_matrix(transform: ArrayLike) -> Floats:
    matrix = np.asanyarray(transform, dtype=np.float64)
    if matrix.shape != (4, 4):
        raise ValueError("transform must be (4,4)!")
    return matrix


def _is_rigid(transform: Floats) -> bool:
    rotation = transform[:3, :3]
    deviation = np.abs(rotation @ rotation.T - np.eye(3)).max()
    return bool(deviation <= _RIGID and np.linalg.det(rotation) > 0)


def _object(mesh: Any, transform: ArrayLike | None) -> fcl.CollisionObject:
    matrix = np.eye(4) if transform is None else _as_matrix(transform)
    if not _is_rigid(matrix):
        mesh, matrix = mesh.copy().apply_transform(matrix), np.eye(4)
    geometry = mesh_to_convex(mesh) if mesh.is_convex else mesh_to_BVH(mesh)
    return fcl.CollisionObject(geometry, fcl.Transform._from_matrix(matrix))


class CollisionManager:
    """Meshes by name, each at a transform."""

    def __init__(self) -> None:
        self._objs: dict[Any, dict[str, Any]] = {}
        self._scene = Scene()
        self._names: dict[int, Any] = {}

    def add_object(self, name: Any, mesh: Any, transform: ArrayLike | None = None) -> fcl.CollisionObject:
        """Add a mesh at a transform, (4, 4); replace the mesh of that name."""
        obj = _object(mesh, transform)
        if name in self._objs:
            self.remove_object(name)
        number = obj._add_to(self._scene)
        self._objs[name] = {"obj": obj, "geom": obj.collision_geometry, "mesh": mesh, "number": number}
        self._names[number] = name
        return obj

    def _entry(self, name: Any) -> dict[str, Any]:
        if name not in self._objs:
            raise ValueError(f"{name} not in collision manager!")
        return self._objs[name]

    def remove_object(self, name: Any) -> None:
        """Remove the mesh of a name."""
        number = self._entry(name)["number"]
        self._scene.remove(number)
        del self._objs[name], self._names[number]

    def set_transform(self, name: Any, transform: ArrayLike) -> None:
        """Place the mesh of a name at another transform, (4, 4)."""
        entry = self._entry(name)
        matrix = _as_matrix(transform)
        if entry.get("scaled") or not _is_rigid(matrix):
            self.add_object(name, entry["mesh"], matrix)
            self._objs[name]["scaled"] = True
            return
        entry["obj"]._matrix = matrix.copy()
        self._scene.move(entry["number"], matrix)

    def in_collision_single(
        self, mesh: Any, transform: ArrayLike | None = None, return_names: bool = False, return_data: bool = False
    ) -> Any:
        """Whether a mesh meets any of the manager's; with the set of their names, and a list of contacts."""
        other = CollisionManager()
        other.add_object(_EXTERNAL, mesh, transform)
        is_hit, pairs, data = self._in_collision(other, return_names or return_data, return_data)
        return _returned(is_hit, {names[0] for names in pairs}, data, return_names, return_data)

    def in_collision_internal(self, return_names: bool = False, return_data: bool = False) -> Any:
        """Whether any two meshes meet; with the set of pairs of names, sorted, and a list of contacts."""
        is_hit, pairs, data = self._in_collision(None, return_names or return_data, return_data)
        names = {tuple(sorted(names)) for names in pairs}
        return _returned(is_hit, names, data, return_names, return_data)

    def in_collision_other(
        self, other_manager: CollisionManager, return_names: bool = False, return_data: bool = False
    ) -> Any:
        """Whether any mesh meets one of another manager; with the set of pairs of names, and a list of contacts."""
        is_hit, pairs, data = self._in_collision(other_manager, return_names or return_data, return_data)
        return _returned(is_hit, set(pairs), data, return_names, return_data)

    def _in_collision(
        self, other: CollisionManager | None, all_pairs: bool, all_contacts: bool
    ) -> tuple[bool, list[tuple[Any, Any]], list[ContactData]]:
        scene = None if other is None else other._scene
        if not all_pairs:
            return self._scene.collide(other=scene), [], []
        numbers = self._scene.pairs(other=scene)
        theirs = self if other is None else other
        pairs = [(self._names[a], theirs._names[b]) for a, b in numbers]
        data = []
        for a, b in pairs if all_contacts else []:
            request, result = fcl.CollisionRequest(_CONTACTS_PER_PAIR, True), fcl.CollisionResult()
            fcl.collide(self._objs[a]["obj"], theirs._objs[b]["obj"], request, result)
            data += [ContactData((a, b), contact) for contact in result.contacts]
        return bool(pairs), pairs, data

    def min_distance_single(
        self, mesh: Any, transform: ArrayLike | None = None, return_name: bool = False, return_data: bool = False
    ) -> Any:
        """The distance of a mesh from the nearest one; with its name, and the closest points."""
        other = CollisionManager()
        other.add_object(_EXTERNAL, mesh, transform)
        distance, names, data = self._min_distance(self._scene, other)
        return _returned(distance, None if names is None else names[0], data, return_name, return_data)

    def min_distance_internal(self, name: Any = None, return_names: bool = False, return_data: bool = False) -> Any:
        """The least distance of two meshes, or of a named mesh from any other; with their names, sorted, and points."""
        if name is None:
            distance, names, data = self._min_distance(self._scene, None)
        else:
            entry = self._entry(name)
            others = self._scene.copy()
            others.remove(entry["number"])
            alone = CollisionManager()
            alone._objs = self._objs
            alone._names = {entry["obj"]._add_to(alone._scene): name}
            distance, names, data = self._min_distance(others, alone)
        return _returned(distance, None if names is None else tuple(sorted(names)), data, return_names, return_data)

    def min_distance_other(
        self, other_manager: CollisionManager, return_names: bool = False, return_data: bool = False
    ) -> Any:
        """The least distance of a mesh from one of another manager; with their names, and points."""
        distance, names, data = self._min_distance(self._scene, other_manager)
        return _returned(distance, names, data, return_names, return_data)

    def _min_distance(
        self, scene: Scene, other: CollisionManager | None
    ) -> tuple[float, tuple[Any, Any] | None, DistanceData | None]:
        """The deepest of all pairs that meet."""
        theirs, their_scene = (self, None) if other is None else (other, other._scene)
        pairs = nearest_pairs(scene, their_scene)
        if not pairs:
            return float("inf"), None, None
        request, result, names = fcl.DistanceRequest(True, True), fcl.DistanceResult(), None
        for a, b in pairs:
            before = result.min_distance
            mine, yours = self._names[a], theirs._names[b]
            fcl.distance(self._objs[mine]["obj"], theirs._objs[yours]["obj"], request, result)
            names = (mine, yours) if result.min_distance < before else names
        return result.min_distance, names, None if names is None else DistanceData(names, result)


def _returned(answer: Any, names: Any, data: Any, with_names: bool, with_data: bool) -> Any:
    """The values that a method returns."""
    if not with_names and not with_data:
        return answer
    return (answer, *([names] if with_names else []), *([data] if with_data else []))


def scene_to_collision(scene: Any) -> tuple[CollisionManager, dict[Any, fcl.CollisionObject]]:
    """A manager of the meshes of a trimesh scene, and their objects by node."""
    manager, objects = CollisionManager(), {}
    for node in scene.graph.nodes_geometry:
        transform, geometry = scene.graph[node]
        objects[node] = manager.add_object(node, scene.geometry[geometry], transform)
    return manager, objects
