"""Many objects that are tested together."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from .._simdop import Scene
from .objects import CollisionObject, scene_of
from .queries import collide, distance
from .requests import CollisionData, DistanceData


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


def nearest_pairs(scene: Scene, other: Scene | None) -> list[tuple[int, int]]:
    """The pairs of one scene, or of two, that meet, by their numbers; if none meet, the nearest pair."""
    nearest = scene.clearance(other=other)
    if nearest.bodies is None:
        return []
    return [nearest.bodies] if nearest.upper > 0.0 else scene.pairs(other=other)


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
        number = obj._add_to(self._scene)
        self._numbers[id(obj)] = number
        self._known[number] = obj

    def unregisterObject(self, obj: CollisionObject) -> None:
        """Remove an object, if the manager has it."""
        number = self._numbers.pop(id(obj), None)
        if number is not None:
            self._scene.remove(number)
            del self._known[number]

    def setup(self) -> None:
        """Do nothing: objects are ready when they are added."""

    def update(self, arg: Any = None) -> None:
        """Update the poses of one object, of several, or of all."""
        objects = self._known.values() if arg is None else arg if hasattr(arg, "__len__") else [arg]
        for obj in objects:
            number = self._numbers.get(id(obj))
            if number is not None:
                self._scene.move(number, obj._matrix)

    def getObjects(self) -> list[CollisionObject]:
        """All objects."""
        return list(self._known.values())

    def empty(self) -> bool:
        """Whether the manager has no objects."""
        return not self._known

    def size(self) -> int:
        """Number of objects."""
        return len(self._known)

    def _other(self, other: Any) -> tuple[Scene, dict[int, CollisionObject]]:
        return (other._scene, other._known) if isinstance(other, type(self)) else scene_of([other])

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
        for a, b in nearest_pairs(self._scene, scene):
            callback(self._known[a], known[b], data)
