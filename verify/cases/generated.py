"""Places that nobody has tuned to, drawn from the seed of a case: furnished buildings, empty halls, bare corridors.

Whatever takes the name of a scene can be run `in_generated` one instead.
"""

import asyncio
import math
import random
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from threewe import Pose2D, Robot, RobotProfile, Scene, SceneTables
from threewe.benchmark import optimistic_replanning, spl
from threewe.errors import ConfigError

SIDES = ((14.0, 32.0), (10.0, 20.0))  # [m] of buildings, drawn from these
FAR = 0.4  # of a place's diagonal: far goals are at least so far away, along the shortest path
WALKERS = 6  # in a building with people, where there is room
STROLL = 2.0, 4.0  # [m] that they walk straight on, at least and at most
WALKERS_TRIED = 40

BARE = """\
name: {name}
description: four walls
starts: [[0.0, 0.0, 0.0]]
rooms:
  - {{name: hall, min: [-{x}, -{y}], max: [{x}, {y}], floor: tile, anchor: [0.0, 0.0]}}
walls:
  - {{a: [-{x}, -{y}], b: [{x}, -{y}], thickness: 0.15}}
  - {{a: [{x}, -{y}], b: [{x}, {y}], thickness: 0.15}}
  - {{a: [{x}, {y}], b: [-{x}, {y}], thickness: 0.15}}
  - {{a: [-{x}, {y}], b: [-{x}, -{y}], thickness: 0.15}}
"""


def building(seed: int) -> str:
    """A furnished building, as text; its size and how crowded it is are drawn too."""
    draw = random.Random(seed)
    size = draw.uniform(*SIDES[0]), draw.uniform(*SIDES[1])
    return Scene.generate(seed, difficulty=draw.random(), size=size).to_yaml(f"building_{seed}")


def peopled(seed: int) -> str:
    """A building in which people walk to and fro, wherever it is free straight on."""
    text, draw = building(seed), random.Random(seed)
    with saved(text) as path:
        tables = SceneTables(Scene.load(path), RobotProfile.load("3we_standard_v2"))
    text += "people:\n"
    walkers = 0
    for _ in range(WALKERS_TRIED):
        if walkers < WALKERS and is_scene(more := text + walker(f"walker_{walkers}", tables, draw)):
            text, walkers = more, walkers + 1
    return text if walkers else building(seed)


def walker(name: str, tables: SceneTables, draw: random.Random) -> str:
    """A line of YAML: somebody between two free places; walls and furniture may be between them."""
    while True:
        a, b = (tables.sample_free_pose(draw.randrange(2**31)) for _ in range(2))
        if STROLL[0] <= math.hypot(b.x - a.x, b.y - a.y) <= STROLL[1]:
            route = f"[[{a.x:.2f}, {a.y:.2f}], [{b.x:.2f}, {b.y:.2f}]]"
            return f"  - {{name: {name}, speed: {draw.uniform(0.5, 1.3):.2f}, route: {route}}}\n"


def is_scene(text: str) -> bool:
    """Whether a scene may be so: nobody walks through furniture."""
    try:
        with saved(text) as path:
            Scene.load(path)
    except ConfigError:
        return False
    return True


def hall(seed: int) -> str:
    """A hall in which most lidars see nothing from the middle."""
    side = random.Random(seed).uniform(20.0, 40.0)
    return BARE.format(name=f"hall_{seed}", x=0.5 * side, y=0.5 * side)


def corridor(seed: int) -> str:
    """A corridor along which most lidars see nothing but its walls."""
    draw = random.Random(seed)
    return BARE.format(name=f"corridor_{seed}", x=0.5 * draw.uniform(30.0, 60.0), y=0.5 * draw.uniform(1.6, 3.0))


PLACES = {"building": building, "peopled": peopled, "hall": hall, "corridor": corridor}


@contextmanager
def saved(text: str) -> Iterator[str]:
    """A scene in a file of its name, while it is needed."""
    name = text.split("name:", 1)[1].split()[0]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{name}.yaml"
        path.write_text(text)
        yield str(path)


def in_generated(seed: int, run: Callable[..., dict[str, Any]], place: str = "building", **how: Any) -> dict[str, Any]:
    """A case in a place of its own."""
    with saved(PLACES[place](seed)) as scene:
        return run(seed, scene=scene, **how)


def drive_far(seed: int, scene: str, hardware: str, randomization: str = "none") -> dict[str, Any]:
    """A drive to a far goal, in an unknown map and without a time limit, beside the optimistic replanner's."""
    profile = RobotProfile.load(hardware)
    tables = SceneTables(Scene.load(scene), profile)
    start, goal, geodesic = far_goal(Scene.load(scene), tables, seed)
    best = optimistic_replanning(tables, profile, start, goal)
    case = asyncio.run(drive_to(scene, hardware, seed, start, goal, geodesic, randomization))
    return case | {"geodesic": geodesic, "optimist_spl": spl(best.reached, geodesic, best.length)}


async def drive_to(
    scene: str,
    hardware: str,
    seed: int,
    start: Pose2D,
    goal: tuple[float, float],
    geodesic: float,
    randomization: str = "none",
) -> dict[str, Any]:
    to = start.inverse() * Pose2D(*goal, 0.0)
    async with Robot(scene=scene, hardware=hardware, seed=seed, start_pose=start, randomization=randomization) as robot:
        truth = robot.simulation
        assert truth is not None
        result = await robot.move_to(to.x, to.y)
        pose = truth.true_pose()
        velocity = robot.get_velocity()
        distance = math.hypot(pose.x - goal[0], pose.y - goal[1])
        in_map = start.inverse() * pose
        reached = result.reason.name == "reached"
        return {
            "reason": result.reason.name,
            "detail": result.detail,
            "seconds": result.duration,
            "true_distance": distance,
            "distance": result.distance_to_goal,
            "uncertainty": result.position_uncertainty,
            "off": math.hypot(in_map.x - result.pose.x, in_map.y - result.pose.y),
            "speed": math.hypot(velocity.vx, velocity.vy),
            "spl": spl(reached and distance <= 0.25, geodesic, truth.distance_driven()),
            "contact_speed": truth.max_collision_speed(),
        }


def far_goal(scene: Scene, tables: SceneTables, seed: int) -> tuple[Pose2D, tuple[float, float], float]:
    """A start, a goal, and the length [m] of the shortest path between them."""
    draw = random.Random(seed)
    low, high = scene.min, scene.max
    least = FAR * math.hypot(high[0] - low[0], high[1] - low[1])
    while True:
        start, goal = (tables.sample_free_pose(draw.randrange(2**31)) for _ in range(2))
        geodesic = tables.geodesic((start.x, start.y), (goal.x, goal.y))
        if math.isfinite(geodesic) and geodesic >= least:
            return start, (goal.x, goal.y), geodesic


def no_clock(case: dict[str, Any]) -> bool:
    """The drive does not end by a time limit."""
    return bool(case["reason"] != "timeout")


def says_how_unsure(case: dict[str, Any]) -> bool:
    """It reaches its goal, or says that it cannot be sure of its pose."""
    return bool(case["reason"] in ("reached", "uncertain", "lost"))


def within_its_radius(case: dict[str, Any]) -> bool:
    """Truly within the radius that it states around the pose that it believes in: so in 95 % of drives."""
    return bool(case["off"] <= case["uncertainty"])


def ends_standing(case: dict[str, Any]) -> bool:
    """A drive that says `reached` stands there."""
    return bool(case["reason"] != "reached" or case["speed"] < 0.02)
