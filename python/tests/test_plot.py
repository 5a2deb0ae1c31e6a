"""Figures are not blank, and missing packages are named."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest
from matplotlib import pyplot

from shapes import at, box
from simdop import Body, PlanningScene, Scene, plot
from test_planning import SRDF, URDF

matplotlib.use("agg")


def share_drawn(ax: Any) -> float:
    """The share of coloured pixels."""
    figure = ax.figure
    figure.canvas.draw()
    pixels = np.asarray(figure.canvas.buffer_rgba())[:, :, :3].astype(int)
    pyplot.close(figure)
    return float((np.ptp(pixels, axis=2) > 24).mean())


@pytest.fixture
def arm(tmp_path: Path) -> PlanningScene:
    """An arm of two links, and a post."""
    (tmp_path / "two.urdf").write_text(URDF)
    (tmp_path / "two.srdf").write_text(SRDF)
    scene = PlanningScene(tmp_path / "two.urdf", tmp_path / "two.srdf")
    scene.add("post", Body.cylinder(0.3, 1.0), at(1.2, 0.8))
    return scene


def test_outlines_are_of_the_bodies() -> None:
    for body, volume in [
        (Body.box([1, 2, 3]), 6.0),
        (Body.sphere(1.0), 4 / 3 * np.pi),
        (Body.cylinder(0.5, 2.0), 0.5 * np.pi),
        (Body.cone(0.5, 3.0), 0.25 * np.pi),
        (Body.capsule(0.5, 1.0), (0.25 + 1 / 6) * np.pi),
        (Body.hull(box()[0]), 1.0),
        (Body.shapes([Body.box([1, 1, 1]), Body.box([1, 1, 1], at=at(3))]), 2.0),
    ]:
        vertices, faces = body.mesh(96)
        corners = vertices[faces]
        found = float(np.linalg.det(corners).sum()) / 6
        assert 0.99 * volume < found <= volume * (1 + 1e-9)
    assert len(Body.half_space([0, 0, 1]).mesh()[1]) == 0
    assert len(Body.cloud([[0, 0, 0]]).mesh()[1]) == 0


def test_bodies_and_scenes_are_drawn() -> None:
    scene = Scene()
    scene.add(Body.sphere(0.5), at(1.0))
    scene.add(Body(*box()), at(-1.0))
    ax = plot.scene(scene)
    assert ax.get_xlim()[0] < -1.4
    assert ax.get_xlim()[1] > 1.4
    assert share_drawn(ax) > 0.02
    # An empty figure has nothing but its grey axes.
    assert share_drawn(plot.scene(Scene())) < 1e-3


def test_contacts_are_drawn() -> None:
    body = Body(*box(), solid=True)
    for found in (body.contacts(body, at(0.8, 0.1, 0.1)), body.patches(body, at(0.8, 0.1, 0.1))):
        assert share_drawn(plot.contacts(found)) > 1e-3
    assert share_drawn(plot.contacts([])) < 1e-3


def test_paths_and_clearances_are_drawn(arm: PlanningScene) -> None:
    path = arm.plan([-0.5, 0.0], [1.8, 0.0])
    assert path is not None
    assert arm.free_edges(path[:-1], path[1:]).all()
    assert (path[0].tolist(), path[-1].tolist()) == ([-0.5, 0.0], [1.8, 0.0])
    assert share_drawn(plot.path(arm, path)) > 0.01
    ax = plot.clearance(arm, path, samples=50)
    values = ax.lines[0].get_ydata()
    assert len(values) == 50
    assert (values > 0).all()
    assert share_drawn(ax) > 1e-3
    straight = plot.clearance(arm, [[-0.5, 0.0], [1.8, 0.0]], samples=50)
    assert (straight.lines[0].get_ydata() < 0).any()
    pyplot.close(straight.figure)
    assert share_drawn(plot.planning(arm, path[0])) > 0.003
    assert arm.plan([-0.5, 0.0], [0.59, 0.0], configurations=10) is None


def test_scenes_become_those_of_trimesh(arm: PlanningScene) -> None:
    made = plot.to_trimesh(arm, [0.0, 0.0])
    assert set(made.geometry) == {"upper", "lower", "post"}
    assert made.bounds[1][0] == pytest.approx(1.95)
    scene = Scene()
    number = scene.add(Body.box([1, 1, 1]), at(2.0))
    assert plot.to_trimesh(scene).graph.get(str(number))[0][0, 3] == 2.0
    with pytest.raises(TypeError, match="values"):
        plot.to_trimesh(arm)


def test_what_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("matplotlib", "matplotlib.pyplot", "trimesh"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(ImportError, match="pip install matplotlib"):
        plot.body(Body.sphere(1.0))
    with pytest.raises(ImportError, match="pip install trimesh"):
        plot.to_trimesh(Scene())
