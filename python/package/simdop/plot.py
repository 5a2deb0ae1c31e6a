"""Figures of bodies, scenes, contacts, clearances and paths in matplotlib, and scenes for trimesh's viewer.

Every function draws on ``ax``, or on new axes, which it returns: ``plot.planning(scene, q).figure.savefig("arm.png")``.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arrays import Floats
from ._simdop import Body, Contacts, Patch, PlanningScene, Scene

__all__ = ["body", "clearance", "contacts", "path", "planning", "scene", "to_trimesh"]

_COLOURS = ("#4477aa", "#ee6677", "#228833", "#ccbb44", "#66ccee", "#aa3377", "#bbbbbb")
_LIGHT = np.array([0.4, -0.6, 0.7]) / np.linalg.norm([0.4, -0.6, 0.7])


def _import(name: str, package: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        message = f"simdop.plot needs {package}, which is not installed: pip install {package}"
        raise ImportError(message, name=package) from error


def _axes_3d(ax: Any | None) -> Any:
    if ax is not None:
        return ax
    pyplot = _import("matplotlib.pyplot", "matplotlib")
    return pyplot.figure().add_subplot(projection="3d")


def _rgba(colour: Any, alpha: float, normals: Floats) -> Floats:
    """A colour, shaded for faces with these normals."""
    base = np.array(_import("matplotlib.colors", "matplotlib").to_rgb(colour))
    shade = 0.55 + 0.45 * np.abs(normals @ _LIGHT)
    return np.column_stack([shade[:, None] * base, np.full(len(shade), alpha)])


def _fit(ax: Any, points: Floats) -> None:
    """Widen the limits of axes to include points, with the same scale on all three."""
    if len(points) == 0:
        return
    known = getattr(ax, "_simdop_limits", None)
    low, high = points.min(0), points.max(0)
    if known is not None:
        low, high = np.minimum(low, known[0]), np.maximum(high, known[1])
    ax._simdop_limits = (low, high)
    middle, half = 0.5 * (low + high), 0.5 * max(float((high - low).max()), 1e-12)
    for i, axis in enumerate("xyz"):
        getattr(ax, f"set_{axis}lim")(middle[i] - half, middle[i] + half)
    ax.set_box_aspect((1, 1, 1))


def _split(triangles: Floats, longest: float) -> tuple[Floats, NDArray[np.int64]]:
    """Triangles halved until none is longer, at most 64 parts each; and the triangle that each is a part of."""
    of = np.arange(len(triangles))
    for _ in range(6):
        edges = np.linalg.norm(triangles - np.roll(triangles, -1, axis=1), axis=2)
        is_long = edges.max(axis=1, initial=0.0) > longest
        if not is_long.any():
            break
        # Puts the longest edge first.
        turned = (edges[is_long].argmax(axis=1)[:, None] + np.arange(3)) % 3
        p, q, r = np.take_along_axis(triangles[is_long], turned[:, :, None], axis=1).swapaxes(0, 1)
        middle = 0.5 * (p + q)
        halves = [np.stack([p, middle, r], axis=1), np.stack([middle, q, r], axis=1)]
        triangles = np.concatenate([triangles[~is_long], *halves])
        of = np.concatenate([of[~is_long], of[is_long], of[is_long]])
    return triangles, of


def _draw(ax: Any, bodies: Iterable[tuple[Body, Floats, Any, float]]) -> None:
    """Draw bodies with their poses, colours and opacities, as one collection.

    Triangles are cut small, because matplotlib sorts those of a collection by the depth of their centres.
    """
    parts, colours, corners = [np.zeros((0, 3, 3))], [np.zeros((0, 4))], [np.zeros((0, 3))]
    for body, pose, colour, alpha in bodies:
        vertices, faces = body.mesh()
        vertices = vertices @ pose[:3, :3].T + pose[:3, 3]
        triangles = vertices[faces]
        normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
        parts.append(triangles)
        colours.append(_rgba(colour, alpha, normals))
        corners.append(vertices)
    points = np.concatenate(corners)
    if len(points) > 0:
        small, of = _split(np.concatenate(parts), 0.1 * float(np.ptp(points, axis=0).max()))
        art = _import("mpl_toolkits.mplot3d.art3d", "matplotlib")
        ax.add_collection3d(art.Poly3DCollection(small, facecolors=np.concatenate(colours)[of], linewidths=0))
    _fit(ax, points)


def body(
    body: Body, pose: ArrayLike | None = None, *, ax: Any | None = None, color: Any = _COLOURS[0], alpha: float = 1.0
) -> Any:
    """Draw a body, placed by ``pose``, (4, 4). A half-space is not drawn. Returns the axes.

    Raises ``ImportError`` without matplotlib.
    """
    ax = _axes_3d(ax)
    _draw(ax, [(body, np.eye(4) if pose is None else np.asarray(pose, float), color, alpha)])
    return ax


def scene(scene: Scene, *, ax: Any | None = None, alpha: float = 1.0) -> Any:
    """Draw all bodies of a scene, each in its own colour. Returns the axes."""
    ax = _axes_3d(ax)
    numbers = enumerate(scene.numbers)
    _draw(ax, [(scene.body(n), scene.pose(n), _COLOURS[i % len(_COLOURS)], alpha) for i, n in numbers])
    return ax


def planning(scene: PlanningScene, values: ArrayLike, *, ax: Any | None = None, alpha: float = 1.0) -> Any:
    """Draw a robot at a configuration, (n,), and the objects around it. Bodies that meet are red. Returns the axes."""
    ax = _axes_3d(ax)
    meeting = {name for pair in scene.hits(values) for name in pair}
    robot, bodies = len(scene.links), []
    for i, (name, shape, pose) in enumerate(scene.placed(values)):
        usual = _COLOURS[0] if i < robot else _COLOURS[6]
        bodies.append((shape, pose, _COLOURS[1] if name in meeting else usual, alpha))
    _draw(ax, bodies)
    return ax


def path(scene: PlanningScene, configurations: ArrayLike, *, ax: Any | None = None, shown: int = 6) -> Any:
    """Draw a path, (m, n): the objects, ``shown`` robots along it, and the trace of the last body. Returns the axes."""
    ax = _axes_3d(ax)
    dense, _ = _dense(configurations, 64)
    robot, robots = len(scene.links), np.linspace(0, len(dense) - 1, shown).round().astype(int)
    bodies = [(shape, pose, _COLOURS[6], 1.0) for _, shape, pose in scene.placed(dense[0])[robot:]]
    for i in robots:
        alpha = 0.25 + 0.75 * float(i) / max(len(dense) - 1, 1)
        bodies += [(shape, pose, _COLOURS[0], alpha) for _, shape, pose in scene.placed(dense[i])[:robot]]
    _draw(ax, bodies)
    ends = []
    for values in dense:
        _, shape, pose = scene.placed(values)[robot - 1]
        vertices = shape.mesh(8)[0]
        ends.append(pose[:3, :3] @ vertices.mean(0) + pose[:3, 3])
    # Drawn above the bodies, which would hide it even where it is in front of them.
    ax.plot(*np.array(ends).T, color=_COLOURS[5], linewidth=2, zorder=1000)
    return ax


def contacts(found: Contacts | Iterable[Patch], *, ax: Any | None = None, color: Any = _COLOURS[1]) -> Any:
    """Draw contacts, or patches with their points, as dots with arrows along their normals. Returns the axes."""
    ax = _axes_3d(ax)
    if isinstance(found, Contacts):
        points, normals = found.points, found.normals
    else:
        patches = list(found)
        points = np.concatenate([np.zeros((0, 3)), *(patch.points for patch in patches)])
        rows = [np.tile(patch.normal, (len(patch.points), 1)) for patch in patches]
        normals = np.concatenate([np.zeros((0, 3)), *rows])
    if len(points) > 0:
        reach = 0.3 * max(float(np.ptp(points, axis=0).max()), 1e-12)
        ax.scatter(*points.T, color=color, s=40, depthshade=False)
        ax.quiver(*points.T, *normals.T, length=reach, color=color)
        _fit(ax, np.concatenate([points, points + reach * normals]))
    return ax


def _dense(configurations: ArrayLike, samples: int) -> tuple[Floats, Floats]:
    """Configurations evenly along a path, and their path lengths in joint values."""
    corners = np.atleast_2d(np.asarray(configurations, float))
    lengths = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    at = np.linspace(0.0, along[-1], samples)
    return np.column_stack([np.interp(at, along, column) for column in corners.T]), at


def clearance(
    scene: PlanningScene, configurations: ArrayLike, *, ax: Any | None = None, samples: int = 200, cutoff: float = 1.0
) -> Any:
    """Draw the signed clearance along a path, (m, n): below 0, bodies overlap by that depth. Returns the axes."""
    if ax is None:
        ax = _import("matplotlib.pyplot", "matplotlib").figure().add_subplot()
    dense, at = _dense(configurations, samples)
    values, _ = scene.signed_clearances(dense, cutoff=cutoff, threads=0)
    ax.plot(at, values, color=_COLOURS[0])
    ax.fill_between(at, values, 0.0, where=values < 0.0, color=_COLOURS[1], alpha=0.5)
    ax.axhline(0.0, color="black", linewidth=0.8)
    ax.set_xlabel("length of the path in the joints")
    ax.set_ylabel("signed clearance")
    return ax


def to_trimesh(scene: Scene | PlanningScene, values: ArrayLike | None = None) -> Any:
    """A ``trimesh.Scene`` of all bodies, for its viewer: ``plot.to_trimesh(scene).show()``.

    A planning scene needs the configuration ``values``, (n,). Raises ``ImportError`` without trimesh.
    """
    trimesh = _import("trimesh", "trimesh")
    made = trimesh.Scene()
    if isinstance(scene, PlanningScene):
        if values is None:
            raise TypeError("to_trimesh of a planning scene needs the values of its joints")
        placed = scene.placed(values)
    else:
        placed = [(str(number), scene.body(number), scene.pose(number)) for number in scene.numbers]
    for name, shape, pose in placed:
        vertices, faces = shape.mesh()
        if len(faces) > 0:
            mesh = trimesh.Trimesh(vertices, faces.astype(np.int64), process=False)
            made.add_geometry(mesh, node_name=name, geom_name=name, transform=pose)
    return made
