"""viser shows the bodies where they are."""

from __future__ import annotations

import importlib
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shapes import at
from simdop import Body, PlanningScene, Scene
from test_planning import SRDF, URDF

viser = pytest.importorskip("viser", reason="viser is not installed: its views are not tested")
view = pytest.importorskip("simdop.view")


@pytest.fixture
def server() -> Iterator[Any]:
    """A server on any free port."""
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield server
    server.stop()


def shown(server: Any) -> dict[str, Any]:
    """What was added, by name."""
    return {name: handle for name, handle in server.scene._handle_from_node_name.items() if hasattr(handle, "vertices")}


def pose_of(handle: Any) -> np.ndarray:
    """The matrix of a handle."""
    w, x, y, z = handle.wxyz
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, 3] = handle.position
    return pose


def test_bodies_of_a_scene_are_shown(server: Any) -> None:
    scene = Scene()
    number = scene.add(Body.box([1, 2, 3]), at(1.0, 2.0, 3.0))
    scene.add(Body.half_space([0, 0, 1]))
    assert view.scene(scene, server=server) is server
    assert list(shown(server)) == [f"/{number}"]
    assert pose_of(shown(server)[f"/{number}"]) == pytest.approx(at(1.0, 2.0, 3.0))


def test_a_slider_moves_the_robot_along_its_path(server: Any, tmp_path: Path) -> None:
    (tmp_path / "two.urdf").write_text(URDF)
    (tmp_path / "two.srdf").write_text(SRDF)
    scene = PlanningScene(tmp_path / "two.urdf", tmp_path / "two.srdf")
    for _ in range(2):
        scene.add("post", Body.cylinder(0.3, 1.0), at(1.2, 0.8))
    path = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 3.0]])
    view.path(scene, path, server=server)
    assert list(shown(server)) == ["/upper", "/lower", "/objects/0/post", "/objects/1/post"]
    (slider,) = (handle for handle in server.gui._gui_input_handle_from_uuid.values() if handle.label == "path")
    # The first corner is at a quarter of the length; at five eighths, the elbow is halfway.
    for value, values in [(0.25, path[1]), (0.625, [1.0, 1.5]), (1.0, path[2]), (0.0, path[0])]:
        slider.value = value
        poses = {f"/{name}": pose for name, _, pose in scene.placed(values)}
        for name in ("/upper", "/lower"):
            for _ in range(100):
                if np.allclose(pose_of(shown(server)[name]), poses[name], atol=1e-6):
                    break
                time.sleep(0.02)
            assert pose_of(shown(server)[name]) == pytest.approx(poses[name], abs=1e-6)


def test_without_viser_the_message_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    monkeypatch.delitem(sys.modules, "simdop.view")
    with pytest.raises(ImportError, match="pip install viser"):
        importlib.import_module("simdop.view")
