"""Checkers for OMPL 2 (``pip install ompl``): state validity, with clearance, and certified motions.

``space_information(scene)`` returns OMPL's space of a ``PlanningScene`` with both; ``solve`` plans in it::

    from ompl import geometric
    path = simdop.ompl.solve(scene, start, goal, planner=geometric.RRTConnect)  # (m, n), or None

The scene must not change while OMPL plans. ``examples/motion_bench_maker.py`` is a complete program.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import Floats
from ._simdop import PlanningScene

try:
    from ompl import base, geometric
except ImportError as error:
    message = "simdop.ompl needs OMPL 2, which is not installed: pip install ompl"
    raise ImportError(message, name="ompl") from error

__all__ = ["Joints", "MotionValidator", "StateValidityChecker", "solve", "space_information"]


class Joints:
    """How OMPL's states store the variables of a scene.

    The states of ``space`` are real vectors within the limits. With continuous joints they are compound states: a real
    vector for the others, then an angle for each continuous joint, which takes the shorter way around.
    """

    def __init__(self, scene: PlanningScene) -> None:
        is_continuous = scene.continuous
        self._bounded, self._angles = np.flatnonzero(~is_continuous).tolist(), np.flatnonzero(is_continuous).tolist()
        self._limits = scene.limits[~is_continuous]
        vectors = base.RealVectorStateSpace(len(self._bounded))
        bounds = base.RealVectorBounds(len(self._bounded))
        for i, (low, high) in enumerate(self._limits.tolist()):
            bounds.setLow(i, low)
            bounds.setHigh(i, high)
        vectors.setBounds(bounds)
        self.space: Any = vectors
        if self._angles:
            spaces = [vectors, *(base.SO2StateSpace() for _ in self._angles)]
            self.space = base.CompoundStateSpace(spaces, [1.0] * len(spaces))

    def values(self, state: Any) -> Floats:
        """The values of the variables in a state, (n,)."""
        if not self._angles:
            return np.array(state[0 : len(self._bounded)])
        found = np.empty(len(self._bounded) + len(self._angles))
        found[self._bounded] = state[0][0 : len(self._bounded)]
        found[self._angles] = [state[1 + i].value for i in range(len(self._angles))]
        return found

    def state(self, values: ArrayLike) -> Any:
        """A new state with these values, (n,)."""
        given = np.asarray(values, float)
        if given.shape != (len(self._bounded) + len(self._angles),):
            message = f"values of the shape {given.shape}, of {len(self._bounded) + len(self._angles)} variables"
            raise ValueError(message)
        state = self.space.allocState()
        vector = state[0] if self._angles else state
        vector[0 : len(self._bounded)] = given[self._bounded].tolist()
        for i, variable in enumerate(self._angles):
            angle = float(given[variable])
            state[1 + i].value = angle if abs(angle) <= np.pi else math.remainder(angle, math.tau)
        return state

    def are_within_limits(self, values: Floats) -> bool:
        """Whether the values of all joints that have limits are within them. NaN is not."""
        bounded = values[self._bounded]
        return bool(((self._limits[:, 0] <= bounded) & (bounded <= self._limits[:, 1])).all())


class StateValidityChecker(base.StateValidityChecker):  # type: ignore[misc]
    """A state is valid if it is within the limits and certainly free, by ``margin`` at least."""

    def __init__(self, si: Any, scene: PlanningScene, joints: Joints, *, margin: float = 0.0) -> None:
        super().__init__(si)
        self._scene, self._joints, self._margin = scene, joints, margin

    def isValid(self, state: Any) -> bool:  # noqa: N802
        """Whether the state is valid."""
        values = self._joints.values(state)
        return self._joints.are_within_limits(values) and self._scene.is_free(values, margin=self._margin)

    def clearance(self, state: Any) -> float:
        """A lower bound on the least distance of two tested bodies, tight up to rounding. 0 outside the limits."""
        values = self._joints.values(state)
        return self._scene.clearance(values).lower if self._joints.are_within_limits(values) else 0.0


class MotionValidator(base.MotionValidator):  # type: ignore[misc]
    """A motion is valid if it is certainly free at all times, not only at samples."""

    def __init__(self, si: Any, scene: PlanningScene, joints: Joints) -> None:
        super().__init__(si)
        self._scene, self._joints = scene, joints

    def checkMotion(self, s1: Any, s2: Any) -> bool:  # noqa: N802
        """Whether the motion is valid."""
        start, end = self._joints.values(s1), self._joints.values(s2)
        are_within = self._joints.are_within_limits(start) and self._joints.are_within_limits(end)
        return are_within and self._scene.edge_is_free(start, end)

    def checkMotionWithLastValid(self, s1: Any, s2: Any, last_valid: Any | None) -> tuple[bool, float]:  # noqa: N802
        """Whether the motion is valid, and the share of it, from ``s1``, that is: 0 if not even ``s1`` is valid.

        If the motion is invalid, ``last_valid``, unless None, becomes the state at that share. OMPL calls this from
        version 2.1 on; before, its planners know only whether a motion is valid.
        """
        start, end = self._joints.values(s1), self._joints.values(s2)
        if not (self._joints.are_within_limits(start) and self._joints.are_within_limits(end)):
            share = 0.0
        else:
            share = self._scene.free_share(start, end)
        if share < 1.0 and last_valid is not None:
            self._joints.space.interpolate(s1, s2, share, last_valid)
        return share == 1.0, share


def space_information(scene: PlanningScene, *, margin: float = 0.0) -> tuple[Any, Joints]:
    """OMPL's ``SpaceInformation`` for the variables of a scene, set up with both checkers, and the states' layout.

    ``margin`` is that of ``StateValidityChecker``. Motions are certified without it.
    """
    joints = Joints(scene)
    si = base.SpaceInformation(joints.space)
    si.setStateValidityChecker(StateValidityChecker(si, scene, joints, margin=margin))
    si.setMotionValidator(MotionValidator(si, scene, joints))
    si.setup()
    return si, joints


def solve(
    scene: PlanningScene,
    start: ArrayLike,
    goal: ArrayLike,
    *,
    planner: Callable[[Any], Any] | None = None,
    seconds: float = 1.0,
    simplify: bool = False,
) -> Floats | None:
    """A path from ``start`` to ``goal``, (n,) each, whose straight motions are certified: (m, n), or None.

    ``planner`` makes a planner from a ``SpaceInformation``: by default ``ompl.geometric.RRTConnect``. It may take
    ``seconds``, and with ``simplify`` as many to shorten the path.
    """
    si, joints = space_information(scene)
    setup = geometric.SimpleSetup(si)
    setup.setStartAndGoalStates(joints.state(start), joints.state(goal))
    setup.setPlanner((planner or geometric.RRTConnect)(si))
    setup.solve(seconds)
    if not setup.haveExactSolutionPath():
        return None
    if simplify:
        setup.simplifySolution(seconds)
    return np.array([joints.values(state) for state in setup.getSolutionPath().getStates()])
