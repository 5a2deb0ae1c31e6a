"""OMPL with simdop's verdicts, against those of the scene, python-fcl and closed forms."""

from __future__ import annotations

import importlib.util
import itertools
import json
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import matplotlib
import numpy as np
import pytest
from matplotlib import image

from shapes import at
from simdop import Body, PlanningScene
from test_planning import SRDF, URDF

base = pytest.importorskip("ompl.base", reason="OMPL is not installed: its verdicts are not tested")
geometric = pytest.importorskip("ompl.geometric")
util = pytest.importorskip("ompl.util")
ompl = pytest.importorskip("simdop.ompl")
util.setLogLevel(util.LOG_ERROR)
matplotlib.use("agg")

EXAMPLE = Path(__file__).parent.parent / "examples" / "motion_bench_maker.py"
WHEEL = """<robot name="wheel"><link name="hub"/><link name="slide"/><link name="spoke"><collision>
<origin xyz="1 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="lift" type="prismatic"><parent link="hub"/><child link="slide"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="axle" type="continuous"><parent link="slide"/><child link="spoke"/><axis xyz="0 0 1"/></joint></robot>"""


@pytest.fixture
def arm(tmp_path: Path) -> PlanningScene:
    """An arm of two links, and a thin post."""
    (tmp_path / "two.urdf").write_text(URDF)
    (tmp_path / "two.srdf").write_text(SRDF)
    scene = PlanningScene(tmp_path / "two.urdf", tmp_path / "two.srdf")
    scene.add("post", Body.cylinder(1e-3, 1.0), at(1.2, 0.8))
    return scene


def test_states_are_valid_where_the_scene_is_free(arm: PlanningScene, rng: np.random.Generator) -> None:
    si, joints = ompl.space_information(arm)
    checker = si.getStateValidityChecker()
    many = rng.uniform(-3, 3, size=(300, 2))
    free = arm.free(many)
    for q, is_free in zip(many, free, strict=True):
        state = joints.state(q)
        assert (joints.values(state) == q).all()
        assert si.isValid(state) == is_free
        assert checker.clearance(state) == arm.clearance(q).lower
    assert 20 < free.sum() < 300
    for outside in ([3.1, 0.0], [0.0, -3.1], [np.nan, 0.0], [np.inf, 0.0]):
        assert not si.isValid(joints.state(outside))
        assert checker.clearance(joints.state(outside)) == 0.0
    wide, _ = ompl.space_information(arm, margin=0.1)
    assert [wide.isValid(joints.state(q)) for q in many] == list(arm.free(many, margin=0.1))
    with pytest.raises(ValueError, match="2 variables"):
        joints.state([0.0])


def test_motions_are_certified_and_not_sampled(arm: PlanningScene, rng: np.random.Generator) -> None:
    si, joints = ompl.space_information(arm)
    validator = si.getMotionValidator()
    sampled = base.SpaceInformation(si.getStateSpace())
    sampled.setStateValidityChecker(si.getStateValidityChecker())
    sampled.setStateValidityCheckingResolution(0.05)
    sampled.setup()
    missed = partly = 0
    for start, end in rng.uniform(-3, 3, size=(150, 2, 2)):
        s, e, last = joints.state(start), joints.state(end), joints.state([9.0, 9.0])
        is_free = arm.edge_is_free(start, end)
        assert si.checkMotion(s, e) == is_free
        missed += sampled.checkMotion(s, e) and not is_free
        is_valid, share = validator.checkMotionWithLastValid(s, e, last)
        assert (is_valid, share) == (is_free, arm.free_share(start, end))
        if is_free:
            assert share == 1.0
            assert (joints.values(last) == 9.0).all()
        else:
            assert joints.values(last) == pytest.approx(start + share * (end - start), abs=1e-12)
            assert not arm.edge_is_free(start, start + (share + 1 / 1024) * (end - start))
            partly += share > 0.0 and arm.edge_is_free(start, joints.values(last))
            assert share == 0.0 or arm.edge_is_free(start, joints.values(last))
        assert validator.checkMotionWithLastValid(s, e, None) == (is_valid, share)
    # Samples find this free, though the arm sweeps over the post.
    assert missed > 5
    assert partly > 20
    outside = joints.state([0.0, 3.5])
    assert not si.checkMotion(joints.state([0.0, 0.0]), outside)
    assert validator.checkMotionWithLastValid(joints.state([0.0, 0.0]), outside, None) == (False, 0.0)


@pytest.mark.parametrize("planner", ["RRTConnect", "RRT", "PRM", "LBKPIECE1"])
def test_paths_of_planners_are_certified(arm: PlanningScene, planner: str) -> None:
    start, goal = [-0.5, 1.0], [2.0, 1.0]
    assert not arm.edge_is_free(start, goal)
    for simplify in (False, True):
        path = ompl.solve(
            arm, start, goal, planner=getattr(geometric, planner), seconds=5.0 - 4.9 * simplify, simplify=simplify
        )
        assert path is not None
        assert path[0].tolist() == start
        assert path[-1].tolist() == goal
        assert arm.free_edges(path[:-1], path[1:]).all()
    assert ompl.solve(arm, start, [3.5, 0.0], planner=getattr(geometric, planner), seconds=0.05) is None


def test_continuous_joints_take_the_shorter_way(tmp_path: Path, rng: np.random.Generator) -> None:
    (tmp_path / "wheel.urdf").write_text(WHEEL)
    scene = PlanningScene(tmp_path / "wheel.urdf")
    scene.add("ahead", Body.box([0.1, 0.1, 0.1]), at(1.0))
    assert scene.variables == ["lift", "axle"]
    assert scene.continuous.tolist() == [False, True]
    si, joints = ompl.space_information(scene)
    # From 3 to -3 the spoke turns behind the hub, where the box ahead is not in the way.
    assert si.checkMotion(joints.state([0.0, 3.0]), joints.state([0.0, -3.0]))
    assert not si.checkMotion(joints.state([0.0, 1.0]), joints.state([0.0, -1.0]))
    for q in rng.uniform([-1, -9], [1, 9], size=(50, 2)):
        state = joints.state(q)
        values = joints.values(state)
        assert np.allclose([values[0], np.cos(values[1]), np.sin(values[1])], [q[0], np.cos(q[1]), np.sin(q[1])])
        assert si.isValid(state) == scene.is_free(q)
    path = ompl.solve(scene, [0.0, 1.0], [0.0, -1.0], seconds=5.0)
    assert path is not None
    assert len(path) > 2
    assert scene.free_edges(path[:-1], path[1:]).all()


def load_example() -> ModuleType:
    spec = importlib.util.spec_from_file_location("motion_bench_maker", EXAMPLE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def fcl_object(fcl: Any, body: Body) -> Any:
    """The surface of a body."""
    vertices, faces = body.mesh()
    model = fcl.BVHModel()
    model.beginModel(len(vertices), len(faces))
    model.addSubModel(vertices, faces)
    model.endModel()
    return fcl.CollisionObject(model)


def test_problems_of_the_panda_are_solved(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    example = load_example()
    files = [data / "robots" / "panda" / "panda.urdf", data / "robots" / "panda" / "panda.srdf"]
    problems, picture = data / "planning" / "mbm_panda.jsonl", tmp_path / "path.png"
    arguments = [*map(str, [*files, problems]), "--every", "250", "--picture", str(picture)]
    assert example.main(arguments) == 0
    assert "3 of 3 solved" in capsys.readouterr().out
    pixels = image.imread(picture)[:, :, :3]
    # The robots are coloured, the table is grey, and the background is white.
    assert np.mean(np.ptp(pixels, axis=2) > 0.1) > 0.005
    assert np.mean((pixels < 0.8).all(axis=2)) > 0.03
    assert np.mean((pixels > 0.99).all(axis=2)) > 0.2
    # Between the configurations of a path, python-fcl finds no link that meets an obstacle.
    fcl = pytest.importorskip("fcl")
    problem = json.loads(problems.read_text().splitlines()[0])
    scene = example.among_obstacles(PlanningScene(*files), problem)
    path = ompl.solve(scene, *example.ends(scene, problem), seconds=10.0)
    assert path is not None
    robot = len(scene.links)
    placed = scene.placed(path[0])
    objects = [fcl_object(fcl, body) for _, body, _ in placed]
    for i, (_, _, pose) in enumerate(placed[robot:]):
        objects[robot + i].setTransform(fcl.Transform(pose[:3, :3], pose[:3, 3]))
    shares = np.linspace(0.0, 1.0, 12)[:, None]
    for start, end in itertools.pairwise(path):
        for values in start + shares * (end - start):
            for i, (_, _, pose) in enumerate(scene.placed(values)[:robot]):
                objects[i].setTransform(fcl.Transform(pose[:3, :3], pose[:3, 3]))
            assert not any(fcl.collide(link, other) for link in objects[:robot] for other in objects[robot:])


def test_without_ompl_the_message_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ompl", None)
    monkeypatch.delitem(sys.modules, "simdop.ompl")
    with pytest.raises(ImportError, match="pip install ompl"):
        importlib.import_module("simdop.ompl")
