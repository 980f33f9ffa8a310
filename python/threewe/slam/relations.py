"""How well a trajectory fits what is known about pairs of places: the error of Kuemmerle et al. 2009.

R. Kuemmerle, B. Steder, C. Dornhege, M. Ruhnke, G. Grisetti, C. Stachniss, A. Kleiner: On measuring the accuracy of
SLAM algorithms. Autonomous Robots 27 (4), 2009. A relation says where the robot was at one time, seen from where it was
at another. The error of a trajectory is how far its own relations are from these: nothing in it depends on where the
map's origin lies, and a bend in the map counts once, not for all that lies behind it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from threewe._arguments import as_array
from threewe._files import read_text
from threewe.errors import ConfigError, ContractError

Array = NDArray[np.float64]

NEAR = 0.1
"""[s] A pose this near in time to a relation's end stands for it; farther away the trajectory is interpolated."""


@dataclass(frozen=True)
class Relations:
    """Pairs of times, and where the robot was at the second, seen from the first."""

    times: Array  # (N, 2) [s]
    poses: Array  # (N, 3) x [m], y [m], yaw [rad]

    @staticmethod
    def read(path: Path) -> Relations:
        """Reads lines `t1 t2 x y z roll pitch yaw`; what does not lie in the plane raises ConfigError, as does a line
        of another form.
        """
        rows = []
        for number, line in enumerate(read_text(path).splitlines(), 1):
            words = line.split("#")[0].split()
            if not words:
                continue
            try:
                row = [float(word) for word in words]
            except ValueError:
                row = []
            if len(row) != 8 or not np.isfinite(row).all():
                raise ConfigError(f"{path}:{number}: a relation is eight numbers: t1 t2 x y z roll pitch yaw")
            rows.append(row)
        if not rows:
            raise ConfigError(f"{path}:1: no relation in it; a relation is eight numbers: t1 t2 x y z roll pitch yaw")
        table = np.array(rows)
        return Relations(table[:, :2], table[:, [2, 3, 7]])

    def write(self, path: Path) -> None:
        """Writes them as `read` takes them."""
        with path.open("w", encoding="utf-8") as file:
            for (t1, t2), (x, y, yaw) in zip(self.times, self.poses, strict=True):
                file.write(f"{t1:.6f} {t2:.6f} {x:.6f} {y:.6f} 0 0 0 {yaw:.8f}\n")


@dataclass(frozen=True)
class Accuracy:
    """Mean and standard deviation of the errors of all relations, translation [m] and rotation [deg]; the same of
    their squares [m^2] and [deg^2].
    """

    relations: int
    left_out: int  # whose times the trajectory does not reach
    translation: tuple[float, float]
    rotation: tuple[float, float]
    squared_translation: tuple[float, float]
    squared_rotation: tuple[float, float]

    def __str__(self) -> str:
        """As the paper's tables have it."""
        (t, st), (r, sr) = self.translation, self.rotation
        return f"{t:.4f} +- {st:.4f} m, {r:.3f} +- {sr:.3f} deg over {self.relations} relations"


def relation_errors(trajectory: Array, relations: Relations) -> tuple[Array, Array, int]:
    """Of each relation the error of translation [m] and rotation [rad], and how many were left out as the trajectory,
    (N, 4) time, x, y, heading, does not reach them.
    """
    trajectory = as_array("trajectory", trajectory, (None, 4))
    relations = Relations(
        as_array("times", relations.times, (None, 2)), as_array("poses", relations.poses, (len(relations.times), 3))
    )
    if not len(trajectory):
        raise ContractError("trajectory must have a pose at least")
    reached = ((relations.times >= trajectory[0, 0] - NEAR) & (relations.times <= trajectory[-1, 0] + NEAR)).all(axis=1)
    first, second = (poses_at(trajectory, relations.times[reached, end]) for end in (0, 1))
    known = relations.poses[reached]
    ours = seen_from(first, second)
    translation = np.linalg.norm(ours[:, :2] - known[:, :2], axis=1)
    rotation = np.abs(wrapped(ours[:, 2] - known[:, 2]))
    return translation, rotation, int((~reached).sum())


def accuracy(trajectory: Array, relations: Relations) -> Accuracy:
    """The figures that Kuemmerle et al. give. Raises ConfigError where no relation is within the trajectory."""
    translation, rotation, left_out = relation_errors(trajectory, relations)
    if not len(translation):
        raise ConfigError(
            f"no relation is within the trajectory: times from {relations.times.min():.3f} to "
            f"{relations.times.max():.3f} s, against {trajectory[0, 0]:.3f} to {trajectory[-1, 0]:.3f} s"
        )
    degrees = np.degrees(rotation)

    def figures(errors: Array) -> tuple[float, float]:
        return float(errors.mean()), float(errors.std())

    return Accuracy(
        len(translation),
        left_out,
        figures(translation),
        figures(degrees),
        figures(translation**2),
        figures(degrees**2),
    )


def poses_at(trajectory: Array, times: Array) -> Array:
    """(M, 3) x, y, heading at some times: those of the nearest scan within `NEAR`, else between two scans."""
    if len(trajectory) == 1:
        return np.repeat(trajectory[:, 1:], len(times), axis=0)
    later = np.clip(np.searchsorted(trajectory[:, 0], times), 1, len(trajectory) - 1)
    a, b = trajectory[later - 1], trajectory[later]
    after_a, before_b = times - a[:, 0], b[:, 0] - times
    share = np.clip(after_a / (b[:, 0] - a[:, 0]), 0.0, 1.0)
    share = np.where(np.minimum(np.abs(after_a), np.abs(before_b)) <= NEAR, np.round(share), share)
    turned = wrapped(b[:, 3] - a[:, 3])
    place = a[:, 1:3] + share[:, None] * (b[:, 1:3] - a[:, 1:3])
    return np.column_stack([place, wrapped(a[:, 3] + share * turned)])


def seen_from(first: Array, second: Array) -> Array:
    """(N, 3): the second poses in the frames of the first."""
    cos, sin = np.cos(first[:, 2]), np.sin(first[:, 2])
    dx, dy = (second - first)[:, :2].T
    return np.column_stack([cos * dx + sin * dy, cos * dy - sin * dx, wrapped(second[:, 2] - first[:, 2])])


def wrapped(angles: Array) -> Array:
    """The same angles in [-pi, pi)."""
    return np.asarray((angles + np.pi) % (2.0 * np.pi) - np.pi)
