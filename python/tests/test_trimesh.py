"""``simdop.trimesh.CollisionManager``, against trimesh's own over python-fcl."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import trimesh

from shapes import at, poses
from simdop.trimesh import CollisionManager, scene_to_collision

MESHES = {
    "box": trimesh.creation.box(),
    "ball": trimesh.creation.icosphere(subdivisions=1, radius=0.6),
    "ring": trimesh.creation.torus(0.8, 0.2, major_sections=12, minor_sections=8),
}


def managers(where: Any) -> list[Any]:
    """The same meshes in both managers."""
    made: list[Any] = [CollisionManager(), trimesh.collision.CollisionManager()]
    for manager in made:
        for (name, mesh), pose in zip(MESHES.items(), where, strict=True):
            manager.add_object(name, mesh, pose)
    return made


def test_answers_are_those_of_trimesh(rng: np.random.Generator) -> None:
    hits = 0
    for _ in range(15):
        mine, his = managers(poses(rng, 3, 2.0))
        other_mine, other_his = managers(poses(rng, 3, 2.0))
        assert mine.in_collision_internal(return_names=True) == his.in_collision_internal(return_names=True)
        found = mine.in_collision_other(other_mine, return_names=True)
        assert found == his.in_collision_other(other_his, return_names=True)
        hits += found[0]
        single = mine.in_collision_single(MESHES["ring"], at(1.0), return_names=True)
        assert single == his.in_collision_single(MESHES["ring"], at(1.0), return_names=True)
        for far in (4.0, 6.0):
            d, name, data = mine.min_distance_single(MESHES["box"], at(far), return_name=True, return_data=True)
            expected, peer_name = his.min_distance_single(MESHES["box"], at(far), return_name=True)
            assert d == pytest.approx(expected, abs=1e-3)
            assert name == peer_name
            assert data.names == {name, "__external"}
            if d > 0:
                gap = np.linalg.norm(data.point(name) - data.point("__external"))
                assert gap == pytest.approx(d)
    assert hits > 0


def test_contacts_name_faces() -> None:
    manager = CollisionManager()
    manager.add_object("ring", MESHES["ring"])
    manager.add_object("other", MESHES["ring"], at(1.0))
    is_hit, names, data = manager.in_collision_internal(return_names=True, return_data=True)
    assert is_hit
    assert names == {("other", "ring")}
    assert len(data) > 4
    for contact in data:
        assert contact.names == {"ring", "other"}
        assert np.linalg.norm(contact.normal) == pytest.approx(1.0)
        assert contact.depth >= 0.0
        corners = MESHES["ring"].triangles[contact.index("ring")]
        assert (contact.point >= corners.min(axis=0) - 1e-6).all()
        assert (contact.point <= corners.max(axis=0) + 1e-6).all()


def test_convex_meshes_are_solids_with_depth() -> None:
    manager = CollisionManager()
    manager.add_object("box", MESHES["box"])
    assert manager.min_distance_single(MESHES["box"], at(0.75)) == pytest.approx(-0.25)
    assert manager.min_distance_single(MESHES["box"], at(3.0)) == pytest.approx(2.0)
    assert manager.in_collision_single(trimesh.creation.box([0.1] * 3))
    is_hit, data = manager.in_collision_single(MESHES["box"], at(0.75), return_data=True)
    assert is_hit
    assert data[0].depth == pytest.approx(0.25)
    assert np.abs(data[0].normal) == pytest.approx([1.0, 0.0, 0.0])


def test_meshes_move_come_and_go() -> None:
    manager = CollisionManager()
    manager.add_object("a", MESHES["box"])
    manager.add_object("b", MESHES["box"], at(3.0))
    manager.add_object("c", MESHES["box"], at(9.0))
    assert manager.min_distance_internal(return_names=True) == (pytest.approx(2.0), ("a", "b"))
    assert manager.min_distance_internal(name="c", return_names=True) == (pytest.approx(5.0), ("b", "c"))
    manager.set_transform("b", at(0.5))
    assert manager.in_collision_internal()
    manager.remove_object("b")
    assert not manager.in_collision_internal()
    manager.add_object("a", MESHES["box"], at(8.5))
    assert manager.in_collision_internal(return_names=True) == (True, {("a", "c")})
    for ask in (manager.remove_object, lambda name: manager.set_transform(name, np.eye(4))):
        with pytest.raises(ValueError, match="not in collision manager"):
            ask("b")


def test_transforms_may_scale() -> None:
    manager = CollisionManager()
    manager.add_object("a", MESHES["box"], np.diag([4.0, 1, 1, 1]))
    assert manager.min_distance_single(MESHES["box"], at(3.0)) == pytest.approx(0.5)
    manager.set_transform("a", np.diag([1.0, 1, -1, 1]))
    assert manager.min_distance_single(MESHES["box"], at(3.0)) == pytest.approx(2.0)
    with pytest.raises(ValueError, match=r"\(4,4\)"):
        manager.add_object("b", MESHES["box"], np.eye(3))


def test_scenes_become_managers() -> None:
    scene = trimesh.Scene([MESHES["box"], MESHES["ball"].copy().apply_translation([3, 0, 0])])
    manager, objects = scene_to_collision(scene)
    assert len(objects) == 2
    assert manager.in_collision_internal() is False
