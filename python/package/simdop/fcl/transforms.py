"""Rigid motions, and their rotations as quaternions."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._arrays import Floats


def from_quaternion(q: Floats) -> Floats:
    """The rotation, (3, 3), of a quaternion w, x, y, z."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def to_quaternion(m: Floats) -> Floats:
    """The quaternion w, x, y, z of a rotation, (3, 3)."""
    # The largest component first: dividing by it is accurate.
    squares = np.array(
        [
            1 + m[0, 0] + m[1, 1] + m[2, 2],
            1 + m[0, 0] - m[1, 1] - m[2, 2],
            1 - m[0, 0] + m[1, 1] - m[2, 2],
            1 - m[0, 0] - m[1, 1] + m[2, 2],
        ]
    )
    i = int(np.argmax(squares))
    root = math.sqrt(squares[i])
    wx, wy, wz = m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]
    xy, xz, yz = m[0, 1] + m[1, 0], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1]
    rows = [[squares[0], wx, wy, wz], [wx, squares[1], xy, xz], [wy, xy, squares[2], yz], [wz, xz, yz, squares[3]]]
    return np.array(rows[i]) / (2 * root)


class Posed:
    """A rotation and a translation."""

    _matrix: Floats

    def getRotation(self) -> Floats:
        """The rotation, (3, 3)."""
        return self._matrix[:3, :3].copy()

    def getTranslation(self) -> Floats:
        """The translation, (3,)."""
        return self._matrix[:3, 3].copy()

    def getQuatRotation(self) -> Floats:
        """The rotation as a quaternion w, x, y, z."""
        return to_quaternion(self._matrix)

    def setRotation(self, R: ArrayLike) -> None:
        """Set the rotation, (3, 3)."""
        self._matrix[:3, :3] = R

    def setTranslation(self, T: ArrayLike) -> None:
        """Set the translation, (3,)."""
        self._matrix[:3, 3] = T

    def setQuatRotation(self, q: ArrayLike) -> None:
        """Set the rotation from a quaternion w, x, y, z."""
        self._matrix[:3, :3] = from_quaternion(np.asarray(q, float))


class Transform(Posed):
    """A rigid motion, from nothing, a rotation (matrix or quaternion), a translation, both, or another transform."""

    def __init__(self, *args: Any) -> None:
        self._matrix = np.eye(4)
        if len(args) > 2:
            raise ValueError("Too many arguments to Transform().")
        if len(args) == 1 and isinstance(args[0], Transform):
            self._matrix = args[0]._matrix.copy()
            return
        if len(args) == 2 and np.squeeze(np.asarray(args[1])).shape != (3,):
            raise ValueError("Translation must be (3,).")
        for i, arg in enumerate(args):
            data = np.asarray(arg, float)
            if i == 0 and data.shape == (3, 3):
                self.setRotation(data)
            elif i == 0 and data.shape == (4,):
                self.setQuatRotation(data)
            elif i == len(args) - 1 and (i == 1 or data.shape == (3,)):
                self.setTranslation(data.squeeze())
            else:
                raise ValueError("Invalid input to Transform().")

    @classmethod
    def _from_matrix(cls, matrix: Floats) -> Transform:
        """The motion of a matrix, (4, 4)."""
        return cls(matrix[:3, :3], matrix[:3, 3])
