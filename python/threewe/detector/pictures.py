"""Labelled pictures of generated buildings: what a detector is trained on, with `simulation.look()` as its teacher.

A picture is the robot's own view, 320 x 240 pixels of 90 degrees; its labels are one per cell of 8 x 8 pixels: the kind
of thing that most of the cell shows, and where that thing's centre is.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from threewe._core import Pose2D, SemanticImage
from threewe.benchmark.unseen import extent_of
from threewe.benchmark.varied import shapes_by_kind, varied_building
from threewe.errors import ConfigError

if TYPE_CHECKING:
    from threewe.simulation import Simulation

WIDTH, HEIGHT, CELL = 320, 240, 8
LABELS = (
    "background",
    *("bed", "box", "cabinet", "chair", "column", "couch", "counter", "cup", "desk", "door", "monitor", "plant"),
    *("refrigerator", "shelf", "table", "tree", "person"),
)
"""What a cell may show. Walls, floors and ceilings are background."""
UNSURE = 255  # a label that is not learnt: the cell shows a bit of many things

MOST = 0.25  # of a cell's pixels, from which on it shows a thing: chairs are legs
FEW = 0.06  # and below which it shows none
VIEWS = 20  # of a building in the same colours
COLOURS = 3  # of a building
LIGHTS = ("none", "mild", "paper", "hard")  # how colours, light and textures are drawn
TYPICAL = 30.0  # cells of a thing that count 1
FARTHEST = 9.0  # [m] of a thing that is learnt
NEAREST = 0.2  # [m] that a thing's centre is taken to be away at least: one may stand in the middle of a large one
SHOWN = 20  # cells of things, from which on a picture is worth learning
PEOPLE = 4  # that are added to a building, at most
PERSON_RADIUS = 0.25  # [m]


@dataclass(frozen=True)
class Labelled:
    """One picture and what it shows."""

    picture: NDArray[np.uint8]
    """(240, 320, 3) BGR, without the camera's noise"""
    kinds: NDArray[np.uint8]
    """(30, 40) index into `LABELS`, or `UNSURE`"""
    offsets: NDArray[np.float32]
    """(30, 40) from the cell's middle to the column of its thing's centre [cells]"""
    nearness: NDArray[np.float32]
    """(30, 40) 1 / (distance of the thing's centre along the optical axis) [1/m]"""
    weights: NDArray[np.float32]
    """(30, 40) how much a cell counts: less, the more cells show the same thing"""


def labelled_pictures(seed: int, buildings: int, workers: int = 1) -> Iterator[Labelled]:
    """Pictures of generated buildings with furniture of all shapes that are not held out, and people.

    The same seed gives the same pictures in the same order, however many processes draw them.
    """
    drawn = partial(_pictures_of, seed)
    if workers == 1:
        yield from itertools.chain.from_iterable(map(drawn, range(buildings)))
        return
    with get_context("spawn").Pool(workers) as pool:
        yield from itertools.chain.from_iterable(pool.imap(drawn, range(buildings)))


def _pictures_of(seed: int, building: int) -> list[Labelled]:
    """Those of one building; none where a person walks where the robot starts."""
    from threewe.robot import Robot

    random = np.random.default_rng([seed, building])
    with TemporaryDirectory() as folder:
        path = Path(folder, "building.yaml")
        people = int(random.integers(PEOPLE + 1))
        path.write_text(varied_building(random, seed * 100_003 + building, people), encoding="utf-8")
        try:
            robot = Robot(
                scene=str(path), localization="truth", randomization=LIGHTS[building % len(LIGHTS)], seed=building
            )
        except ConfigError:
            return []
    assert robot.simulation is not None
    pictures = []
    for colours in range(COLOURS):
        robot.simulation.reset(seed=building, episode=colours)
        pictures += [_interesting(robot.simulation, random) for _ in range(VIEWS)]
    return pictures


def radii() -> list[float]:
    """Of each label, half the mean diagonal [m] of its shapes from above, those that are held out left out."""
    shapes = shapes_by_kind()
    return [0.0, *(_radius(kind, shapes[kind]) if kind in shapes else PERSON_RADIUS for kind in LABELS[1:])]


def _radius(kind: str, shapes: list[str]) -> float:
    extents = [extent_of(kind, shape) for shape in shapes]
    return round(
        sum(math.hypot(x_max - x_min, y_max - y_min) for x_min, y_min, x_max, y_max in extents) / 2 / len(shapes), 2
    )


def _interesting(simulation: Simulation, random: np.random.Generator) -> Labelled:
    """A picture that shows things; of those that show walls alone one in five is taken."""
    while True:
        picture = labelled(simulation, random)
        shown = np.count_nonzero((picture.kinds != 0) & (picture.kinds != UNSURE))
        if shown >= SHOWN or random.random() < 0.2:
            return picture


def labelled(simulation: Simulation, random: np.random.Generator) -> Labelled:
    """What a robot's camera shows at a random pose."""
    robot = simulation.sample_free_pose(int(random.integers(1 << 31)))
    assert simulation.profile.camera is not None
    camera = robot * simulation.profile.camera.base_from_camera
    image = simulation.look(pose=camera, with_itself=False)
    ids = image.ids[::2, ::2]
    kinds_of, columns_of, nearness_of = _things(simulation, image, camera)
    count = len(image.names)
    rows, columns = HEIGHT // CELL, WIDTH // CELL
    y, x = np.indices(ids.shape) // CELL
    cells = (y * columns + x) * count + ids
    shares = np.bincount(cells.ravel(), minlength=rows * columns * count).reshape(-1, count) / CELL**2
    shares[:, kinds_of == 0] = 0.0
    thing = shares.argmax(1)
    share, total = shares.max(1), shares.sum(1)
    kinds = np.where(share >= MOST, kinds_of[thing], np.where(total <= FEW, 0, UNSURE)).astype(np.uint8)
    kinds[(kinds != 0) & (nearness_of[thing] < 1 / FARTHEST)] = UNSURE
    sizes = np.bincount(thing[kinds != 0], minlength=count)
    weights = np.where(kinds != 0, np.sqrt(TYPICAL / np.maximum(sizes[thing], 4)), 1.0)
    middles = (np.arange(rows * columns) % columns + 0.5) * CELL
    offsets = np.clip((columns_of[thing] - middles) / CELL, -12, 12)
    return Labelled(
        _halved(image.color),
        kinds.reshape(rows, columns),
        offsets.astype(np.float32).reshape(rows, columns),
        nearness_of[thing].astype(np.float32).reshape(rows, columns),
        weights.astype(np.float32).reshape(rows, columns),
    )


def _things(
    simulation: Simulation, image: SemanticImage, camera: Pose2D
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Of what each id shows: its label, the column of its centre [px] and its nearness [1/m]; 0 for what is behind."""
    places = {thing.name: (thing.category, thing.pose) for thing in simulation.scene.objects}
    places |= {person.name: ("person", person.pose) for person in simulation.people()}
    known = [places.get(name, ("background", camera)) for name in image.names]
    dx, dy = np.array([(pose.x - camera.x, pose.y - camera.y) for _, pose in known]).T
    ahead = dx * math.cos(camera.theta) + dy * math.sin(camera.theta)
    left = dy * math.cos(camera.theta) - dx * math.sin(camera.theta)
    ahead = np.maximum(ahead, NEAREST)
    columns = WIDTH / 2 - WIDTH / 2 * left / ahead
    return np.array([LABELS.index(label) for label, _ in known]), columns, 1 / ahead


def _halved(color: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The mean of every 2 x 2 pixels, rounded."""
    upper, lower = color[::2].astype(np.uint16), color[1::2].astype(np.uint16)
    pairs = upper + lower
    sums = pairs[:, ::2] + pairs[:, 1::2]
    halved: NDArray[np.uint8] = ((sums + 2) >> 2).astype(np.uint8)
    return halved
