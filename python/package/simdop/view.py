"""Bodies, scenes and paths in a browser, by viser: ``pip install viser``.

Each function adds to ``server``, a ``viser.ViserServer``, or to a new one, and returns it. A new one serves
``http://localhost:8080`` until its ``stop``: ``view.path(scene, path)``.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import Floats
from ._simdop import Body, PlanningScene, Scene

try:
    import viser
    from viser import transforms
except ImportError as error:
    message = "simdop.view needs viser, which is not installed: pip install viser"
    raise ImportError(message, name="viser") from error

__all__ = ["path", "scene"]

_ROBOT, _OBJECT = (68, 119, 170), (187, 187, 187)


def _server(server: Any | None) -> Any:
    # For this machine only: by default, every machine on the network has access.
    return viser.ViserServer(host="127.0.0.1", verbose=False) if server is None else server


def _turn(handle: Any, pose: Floats) -> None:
    handle.wxyz, handle.position = transforms.SO3.from_matrix(pose[:3, :3]).wxyz, pose[:3, 3]


def _add(server: Any, bodies: Iterable[tuple[str, Body, Floats]], colour: tuple[int, int, int]) -> list[Any]:
    """Handles of bodies, or None where there is nothing to draw, such as for a half-space."""
    handles = []
    for name, body, pose in bodies:
        vertices, faces = body.mesh()
        handle = None
        if len(faces) > 0:
            handle = server.scene.add_mesh_simple(
                f"/{name}", vertices.astype(np.float32), faces, color=colour, flat_shading=True, side="double"
            )
            _turn(handle, pose)
        handles.append(handle)
    return handles


def scene(scene: Scene, *, server: Any | None = None) -> Any:
    """Show all bodies of a scene. Returns the server."""
    server = _server(server)
    _add(server, [(str(number), scene.body(number), scene.pose(number)) for number in scene.numbers], _OBJECT)
    return server


def path(scene: PlanningScene, configurations: ArrayLike, *, server: Any | None = None) -> Any:
    """Show a robot among its objects, with a slider along a path, (m, n), whose ends are 0 and 1. Returns the server.

    A single configuration, (n,), has no slider.
    """
    server = _server(server)
    corners = np.atleast_2d(np.asarray(configurations, float))
    placed, robot = scene.placed(corners[0]), len(scene.links)
    handles = _add(server, placed[:robot], _ROBOT)
    # Names of objects need not be unique.
    _add(server, [(f"objects/{i}/{name}", body, pose) for i, (name, body, pose) in enumerate(placed[robot:])], _OBJECT)
    lengths = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    if along[-1] == 0.0:
        return server
    slider = server.gui.add_slider("path", 0.0, 1.0, 1e-3, 0.0)

    @slider.on_update  # type: ignore[untyped-decorator]
    def _(_: Any) -> None:
        values = [np.interp(slider.value * along[-1], along, column) for column in corners.T]
        for handle, (_, _, pose) in zip(handles, scene.placed(values), strict=False):
            if handle is not None:
                _turn(handle, pose)

    return server
