"""A robot from its URDF file, against closed forms and its links in a scene."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import simdop
from shapes import at
from simdop import Body, PlanningScene

LINK = '<collision><origin xyz="0.5 0 0"/><geometry><box size="0.9 0.1 0.1"/></geometry></collision>'
JOINT = (
    '<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/><origin xyz="{3} 0 0"/>'
    '<axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
)
URDF = f"""<robot name="two"><link name="base"/><link name="upper">{LINK}</link><link name="lower">{LINK}</link>
{JOINT.format("shoulder", "base", "upper", 0)}{JOINT.format("elbow", "upper", "lower", 1)}</robot>"""
SRDF = """<robot name="two"><group name="arm"><joint name="shoulder"/><joint name="elbow"/></group>
<group name="last"><joint name="elbow"/></group>
<disable_collisions link1="upper" link2="lower" reason="Adjacent"/></robot>"""


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    """The robot's files."""
    urdf, srdf = tmp_path / "two.urdf", tmp_path / "two.srdf"
    urdf.write_text(URDF)
    srdf.write_text(SRDF)
    return urdf, srdf


def link_poses(q: np.ndarray) -> list[np.ndarray]:
    """The poses of both links in the world, by hand."""
    poses = []
    angle, x, y = 0.0, 0.0, 0.0
    for value in q:
        angle += value
        c, s = np.cos(angle), np.sin(angle)
        pose = at(x, y)
        pose[:2, :2] = [[c, -s], [s, c]]
        poses.append(pose)
        x, y = x + c, y + s
    return poses


def test_configurations_are_those_of_a_scene(files: tuple[Path, Path], rng: np.random.Generator) -> None:
    planning = PlanningScene(*files)
    post, box = Body.cylinder(0.4, 1.0), Body.box([0.9, 0.1, 0.1], at=at(0.5))
    number = planning.add("post", post, at(1.2, 0.8))
    assert planning.objects == {"post": number}
    assert planning.links == ["upper", "lower"]
    assert planning.groups == ["arm", "last"]
    assert planning.variables == ["shoulder", "elbow"]
    assert planning.continuous.tolist() == [False, False]
    assert planning.limits.tolist() == [[-3, 3], [-3, 3]]
    assert len(planning) == 2
    many = rng.uniform(-3, 3, size=(300, 2))
    free = planning.free(many)
    for i, q in enumerate(many):
        gap = min(float(box.distance(post, np.linalg.inv(at(1.2, 0.8)) @ pose)) for pose in link_poses(q))
        assert free[i] == (gap > 0.0)
        assert planning.is_free(q) == free[i]
        assert planning.is_free(q, margin=0.1) is (gap > 0.1)
        assert bool(planning.hits(q)) != free[i]
        assert float(planning.clearance(q)) == pytest.approx(gap, abs=1e-12)
    assert 20 < free.sum() < 280
    for threads in (0, 2, 5):
        assert (planning.free(many, threads=threads) == free).all()


def test_bounds_change_no_verdict(files: tuple[Path, Path], rng: np.random.Generator) -> None:
    planning = PlanningScene(*files)
    planning.add("post", Body.cylinder(0.4, 1.0), at(1.2, 0.8))
    assert planning.bound_bytes is None
    many, ends = (rng.uniform(-3, 3, size=(500, 2)) for _ in range(2))
    free, edges = planning.free(many), planning.free_edges(many, ends)
    assert {*free} == {*edges} == {True, False}
    planning.use_bounds(0.02)
    assert planning.bound_bytes
    assert (planning.free(many) == free).all()
    assert (planning.free_edges(many, ends) == edges).all()
    assert [planning.edge_is_free(*edge) for edge in zip(many, ends, strict=True)] == edges.tolist()
    for cell in (0.0, -1.0, np.nan):
        with pytest.raises(ValueError, match="cell"):
            planning.use_bounds(cell)


def test_points_near_the_robot_are_those_of_closed_forms(files: tuple[Path, Path], rng: np.random.Generator) -> None:
    planning = PlanningScene(*files)
    planning.add("post", Body.cylinder(0.4, 1.0), at(1.2, 0.8))
    points = rng.uniform([-2, -2, -0.3], [2, 2, 0.3], size=(2000, 3)).astype(np.float32)
    for margin in [0.0, 0.1]:
        q = rng.uniform(-3, 3, size=2)
        gaps = []
        for pose in link_poses(q):
            seen = (points.astype(float) - pose[:3, 3]) @ pose[:3, :3] - [0.5, 0, 0]
            gaps.append(np.linalg.norm(np.maximum(np.abs(seen) - [0.45, 0.05, 0.05], 0), axis=1))
        near = np.min(gaps, axis=0) <= margin
        assert 0 < near.sum() < 1000
        assert (planning.near_robot(q, points, margin=margin) == near).all()
    assert not planning.near_robot([0, 0], [[np.nan, 0, 0]]).any()
    with pytest.raises(simdop.ArrayError):
        planning.near_robot([0, 0], [[0, 0]])


def test_gradients_are_those_of_differences(files: tuple[Path, Path], rng: np.random.Generator) -> None:
    planning = PlanningScene(*files)
    planning.add("ball", Body.sphere(0.2), at(1.2, 1.6, 0.3))
    tested = 0
    for q in rng.uniform(-2.5, 2.5, size=(100, 2)):
        near = planning.clearance(q)
        assert near.gradient is not None
        if float(near) < 0.01:
            continue
        step = 1e-6
        ends = [[float(planning.clearance(q + sign * step * unit)) for sign in (-1, 1)] for unit in np.eye(2)]
        slopes = np.array([(high - low) / (2 * step) for low, high in ends])
        # Where the nearest edge changes, there is no derivative.
        tested += bool(np.abs(near.gradient - slopes).max() < 1e-4)
    assert tested > 80


def test_edges_are_free_at_all_times(files: tuple[Path, Path], rng: np.random.Generator) -> None:
    planning = PlanningScene(*files)
    planning.add("post", Body.cylinder(0.2, 1.0), at(1.2, 0.8))
    starts, ends = rng.uniform(-3, 3, size=(2, 100, 2))
    free = planning.free_edges(starts, ends)
    for start, end, is_free in zip(starts, ends, free, strict=True):
        assert planning.edge_is_free(start, end) == is_free
        samples = start + np.linspace(0, 1, 50)[:, None] * (end - start)
        if is_free:
            assert planning.free(samples).all()
    assert 10 < free.sum() < 95
    assert (planning.free_edges(starts, ends, threads=3) == free).all()


def test_groups_attachments_and_copies(files: tuple[Path, Path]) -> None:
    last = PlanningScene(*files, group="last", rest=[np.pi / 2, 0.0])
    assert len(last) == 1
    last.add("ball", Body.sphere(0.1), at(0.0, 1.9))
    assert not last.is_free([0.0])
    assert last.is_free([1.5])
    planning = PlanningScene(*files, base=at(0, 0, 5.0))
    tool = planning.add("tool", Body.sphere(0.2), at(2.2, 0.0, 5.0), fixed=False)
    wall = planning.add("wall", Body.box([0.1, 10, 10]), at(-2.3, 0, 5.0))
    planning.attach(tool, "lower", [0.0, 0.0], ["lower"])
    assert planning.is_free([0.0, 0.0])
    assert planning.hits([2.99, 0.0]) == [("tool", "wall")] or planning.hits([2.99, 0.0]) == [("wall", "tool")]
    copy = planning.copy()
    planning.remove(wall)
    assert planning.is_free([2.99, 0.0])
    assert not copy.is_free([2.99, 0.0])
    planning.detach(tool, at(50))
    assert planning.name(tool) == "tool"
    assert planning.name(planning.link("lower")) == "lower"
    assert repr(planning) == "PlanningScene(2 variables, 2 bodies of the robot, 1 objects)"


def test_bad_input_is_refused(files: tuple[Path, Path]) -> None:
    planning = PlanningScene(*files)
    for q in ([0.0], [0.0, 9.0], [np.nan, 0.0]):
        with pytest.raises(simdop.PlanningError):
            planning.is_free(q)
        with pytest.raises(simdop.PlanningError):
            planning.edge_is_free([0.0, 0.0], q)
    with pytest.raises(simdop.ArrayError, match=r"\(n, 2\)"):
        planning.free(np.zeros((5, 3)))
    with pytest.raises(simdop.ArrayError, match="2 starts and 3 ends"):
        planning.free_edges(np.zeros((2, 2)), np.zeros((3, 2)))
    with pytest.raises(simdop.PlanningError, match="hand"):
        planning.link("hand")
    with pytest.raises(simdop.PlanningError, match="robot"):
        planning.remove(planning.link("upper"))
    with pytest.raises(simdop.PlanningError, match="leg"):
        PlanningScene(*files, group="leg")
    with pytest.raises(simdop.PlanningError, match="group"):
        PlanningScene(*files, rest=[0.0, 0.0])
    with pytest.raises(simdop.PlanningError, match=r"none\.urdf"):
        PlanningScene(files[0].parent / "none.urdf")
    files[0].write_text("<robot>")
    with pytest.raises(simdop.PlanningError, match=r"two\.urdf"):
        PlanningScene(files[0])
    assert planning.free(np.zeros((0, 2))).shape == (0,)


def test_signed_clearances_are_depths_of_links(files: tuple[Path, Path], rng: np.random.Generator) -> None:
    planning = PlanningScene(*files)
    post, box = Body.cylinder(0.4, 1.0), Body.box([0.9, 0.1, 0.1], at=at(0.5))
    planning.add("post", post, at(1.2, 0.8))
    many = rng.uniform(-2.9, 2.9, size=(200, 2))
    values, gradients = planning.signed_clearances(many, threads=2)
    assert gradients.shape == (200, 2)
    smooth = meeting = 0
    for i, q in enumerate(many):
        inverse = np.linalg.inv(at(1.2, 0.8))
        expected = min(float(box.signed_distance(post, inverse @ pose)) for pose in link_poses(q))
        found = planning.signed_clearance(q)
        assert values[i] == float(found)
        assert found.gradient is not None
        assert (gradients[i] == found.gradient).all()
        assert values[i] == pytest.approx(expected, abs=1e-6)
        meeting += values[i] < 0
        step = 1e-6
        moved = [[float(planning.signed_clearance(q + s * step * unit)) for s in (-1, 1)] for unit in np.eye(2)]
        slopes = np.array([(high - low) / (2 * step) for low, high in moved])
        smooth += bool(np.abs(slopes - gradients[i]).max() < 1e-2)
    assert 10 < meeting < 150
    assert smooth > 170
    assert planning.signed_clearances(np.zeros((0, 2)))[1].shape == (0, 2)
    with pytest.raises(simdop.PlanningError):
        planning.signed_clearance([0.0])
    names = [name for name, _, _ in planning.placed([0.0, 0.0])]
    assert names == ["upper", "lower", "post"]
    # The box is half a length ahead of its link.
    upright = link_poses(np.array([np.pi / 2, 0.0]))[1] @ at(0.5)
    assert planning.placed([np.pi / 2, 0.0])[1][2] == pytest.approx(upright, abs=1e-12)
