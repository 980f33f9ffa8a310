"""What every peer is given: the same office, the same places, the same work, and one clock.

Peers import this in a Python of their own, where threewe is not installed.
"""

from __future__ import annotations

import json
import math
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

BEAMS = (64, 360)
PICTURES = ((64, 64), (160, 120), (640, 480))  # [px]; the second is the smallest that ViZDoom draws
FORWARD, TURN = 0.3, 0.5  # [m/s], [rad/s] that robots are commanded
PHYSICS = 0.01  # [s] of a step of physics
SUBSTEPS = 10  # of physics in a step, unless a world has others
PERIOD = SUBSTEPS * PHYSICS  # [s] of a step
RUN = 10  # steps from each place
FEW = 32  # of the places, for what takes long
LOOKED_AT = 64  # of the places: the mean of all ranges from there shows that all see the same
REPEATS = 5
SHORTEST = 0.2  # [s] of a timing


@dataclass(frozen=True)
class Solid:
    """A vertical prism over a rectangle or, with a radius, over a disc."""

    x: float  # [m] of its middle
    y: float
    theta: float  # [rad]
    length: float  # [m]
    width: float
    radius: float
    low: float  # [m] above the floor
    high: float

    @property
    def half(self) -> list[float]:
        """Half of its length, width and height."""
        return [0.5 * self.length, 0.5 * self.width, 0.5 * (self.high - self.low)]


@dataclass
class World:
    """A scene, and places in it where a robot can stand."""

    solids: list[Solid] = field(default_factory=list)
    poses: list[tuple[float, float, float]] = field(default_factory=list)
    lidar_height: float = 0.0  # [m]
    lidar_range: float = 0.0  # [m]
    camera_height: float = 0.0  # [m]
    field_of_view: float = 0.0  # [rad], horizontal
    substeps: int = SUBSTEPS  # of physics in a step

    @property
    def period(self) -> float:
        """Of a step [s]."""
        return self.substeps * PHYSICS

    def write(self, path: Path) -> None:
        """As lines of a word and numbers, which peers in C++ read too."""
        lines = [f"lidar {self.lidar_height!r} {self.lidar_range!r}"]
        lines += [f"camera {self.camera_height!r} {self.field_of_view!r}", f"substeps {self.substeps}"]
        lines += [" ".join(["solid", *(repr(float(value)) for value in vars(solid).values())]) for solid in self.solids]
        lines += [" ".join(["pose", *map(repr, pose)]) for pose in self.poses]
        path.write_text("\n".join(lines) + "\n")

    @staticmethod
    def read(path: Path) -> World:
        """What `write` has written."""
        world = World()
        for line in path.read_text().splitlines():
            word, *numbers = line.split()
            values = [float(number) for number in numbers]
            if word == "solid":
                world.solids.append(Solid(*values))
            elif word == "pose":
                x, y, theta = values
                world.poses.append((x, y, theta))
            elif word == "lidar":
                world.lidar_height, world.lidar_range = values
            elif word == "camera":
                world.camera_height, world.field_of_view = values
            elif word == "substeps":
                world.substeps = int(values[0])
        return world

    def cut(self) -> list[Solid]:
        """What the lidar can meet."""
        return [solid for solid in self.solids if solid.low <= self.lidar_height < solid.high]

    def vertical_field(self, width: int, height: int) -> float:
        """[rad], of square pixels."""
        return 2.0 * math.atan(math.tan(0.5 * self.field_of_view) * height / width)


def given() -> World:
    """The world that this process was started with."""
    return World.read(Path(sys.argv[1]))


def report(
    row: dict[str, object],
    size: str,
    units: int,
    work: Callable[[], object],
    clock: Callable[[], float] = time.process_time,
) -> None:
    """Prints the CPU seconds that each of the `units` of a piece of work takes: several timings, after one to warm up.

    What else runs on the machine counts little that way.
    """

    def seconds(rounds: int) -> float:
        begin = clock()
        for _ in range(rounds):
            work()
        return clock() - begin

    rounds = 1
    while (took := seconds(rounds)) < SHORTEST:
        rounds = max(2 * rounds, math.ceil(rounds * SHORTEST / max(took, 1e-3)))
    timings = [seconds(rounds) / (rounds * units) for _ in range(REPEATS)]
    print(json.dumps({**row, "size": size, "seconds": timings}), flush=True)


def report_drives(
    row: dict[str, object],
    world: World,
    beams: int,
    begin: Callable[[float, float, float], None],
    step: Callable[[], Sequence[float]],
    places: int = FEW,
) -> None:
    """Times steps: from each place in turn a robot drives in an arc. `step` gives what a scan meets."""

    def drive() -> None:
        for place in world.poses[:places]:
            begin(*place)
            for _ in range(RUN):
                step()

    facts = {"kind": "step", "range": world.lidar_range, "period": PERIOD}
    report({**facts, **row}, str(beams), places * RUN, drive)


def report_scans(
    row: dict[str, object],
    world: World,
    beams: int,
    scan: Callable[[float, float, float], Sequence[float]],
    places: int | None = None,
) -> None:
    """Times one turn of the lidar from each of the places, or from some."""
    mean = statistics.fmean(statistics.fmean(scan(*pose)) for pose in world.poses[:LOOKED_AT])
    chosen = world.poses[:places]

    def turn() -> None:
        for pose in chosen:
            scan(*pose)

    facts = {"kind": "scan", "range": world.lidar_range, "mean_range": mean}
    report({**facts, **row}, str(beams), beams * len(chosen), turn)


def report_pictures(
    row: dict[str, object], world: World, width: int, height: int, take: Callable[[float, float, float], None]
) -> None:
    """Times pictures from some of the places."""

    def turn() -> None:
        for pose in world.poses[:FEW]:
            take(*pose)

    report({"kind": "picture", **row}, f"{width}x{height}", FEW, turn)


def plain_colour(i: int) -> list[float]:
    """Red, green, blue and opaque, of the i-th solid."""
    return [0.3 + 0.1 * (i % 6), 0.4 + 0.1 * (i % 5), 0.3 + 0.1 * (i % 4), 1.0]
