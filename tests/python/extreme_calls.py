"""Calls public functions with extreme arguments: `python extreme_calls.py GROUP SEED CALLS`, see test_extremes.py."""

from __future__ import annotations

import asyncio
import faulthandler
import math
import random
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import threewe
from threewe import _core, gym, slam, sync

NUMBERS = [0.0, -0.0, 1.0, -1.0, 0.5, 2.0, 100.0, 1e6, -1e6, 1.0001e6, 1e9, -1e18, 1e300, 1e308, -1e308, 5e-324, 1e-9]
NUMBERS += [math.nan, math.inf, -math.inf]
WHOLE = [
    0,
    1,
    2,
    3,
    5,
    -1,
    255,
    65536,
    2**31 - 1,
    2**31,
    -(2**31),
    2**63 - 1,
    2**63,
    2**64 - 1,
    2**64,
    -(2**63),
    10**400,
]
OTHERS: list[Any] = [None, "", "x", "../x", "\x00", [], {}, (), object(), True, b"x", 1j]
SHAPES = [(0,), (1,), (2,), (3,), (7,), (0, 0), (1, 3), (2, 2), (3, 1), (1, 9000), (2, 3, 4), ()]
KINDS = ["float32", "float64", "int8", "int64", "uint8", "bool", "complex64", "U4", "object"]

LIMIT = 5.0  # [s] of one call, and the same again for what it makes of the machine being busy


class Draw(random.Random):
    """Extreme arguments, mostly of the type that is asked for."""

    def number(self) -> Any:
        return self.choice(NUMBERS) if self.random() < 0.9 else self.choice([*WHOLE, *OTHERS])

    def whole(self) -> Any:
        return self.choice(WHOLE) if self.random() < 0.9 else self.choice([*NUMBERS, *OTHERS])

    def place(self) -> Any:
        return (self.number(), self.number()) if self.random() < 0.9 else self.array()

    def pose(self) -> Any:
        if self.random() < 0.1:
            return self.choice([self.array(), *OTHERS])
        numbers = [self.choice(NUMBERS) for _ in range(3)]
        return threewe.Pose2D(*numbers) if self.random() < 0.7 else tuple(numbers)

    def fine(self) -> threewe.Pose2D:
        return threewe.Pose2D(self.uniform(-1, 1), self.uniform(-1, 1), self.uniform(-3, 3))

    def array(self) -> Any:
        kind = self.choice(KINDS)
        shape = self.choice(SHAPES)
        with np.errstate(all="ignore"):
            values = np.full(shape, self.choice(NUMBERS), dtype="float64")
            return values.astype(kind) if kind != "object" else np.full(shape, None)

    def scan(self) -> threewe.LaserScan:
        """One that is fine but for a number or two."""
        numbers = [-1.5, 0.1, 0.1, 10.0, 0.0]
        for _ in range(self.randrange(3)):
            numbers[self.randrange(5)] = self.choice(NUMBERS)
        ranges = np.full(30, 2.0, dtype=np.float32)
        if self.random() < 0.2:
            ranges[3] = np.float32(self.choice([0.0, 5e-324, 1e30, math.nan, math.inf, -1.0]))
        return threewe.LaserScan(ranges, *numbers)

    def grid(self) -> threewe.OccupancyGrid:
        cells = np.full(self.choice([(0, 0), (1, 1), (40, 30), (3, 8192)]), self.choice([-1, 0, 100]), dtype=np.int8)
        return threewe.OccupancyGrid(cells, self.choice(NUMBERS), (self.choice(NUMBERS), self.choice(NUMBERS)))


Call = Callable[[], object]


def values(draw: Draw) -> list[Call]:
    """Poses, readings, pictures, maps."""
    n, p, a = draw.number, draw.pose, draw.array

    def pose() -> threewe.Pose2D:
        return threewe.Pose2D(draw.choice(NUMBERS), draw.choice(NUMBERS), draw.choice(NUMBERS))

    return [
        lambda: threewe.Pose2D(n(), n(), n()),
        lambda: repr(pose() * pose().inverse()) + str(hash(pose())) + str(pose().distance(pose())),
        lambda: pose().transform(draw.place()),
        lambda: repr(threewe.Velocity(n(), n(), n())),
        lambda: repr(threewe.LaserScan(a(), n(), n(), n(), n(), n())),
        lambda: threewe.CameraIntrinsics(draw.whole(), draw.whole(), n(), n(), n(), n()),
        lambda: threewe.CameraIntrinsics.of_view(draw.whole(), draw.whole(), n()),
        lambda: threewe.IMUData(a(), a()),
        lambda: repr(threewe.Odometry(p(), threewe.Velocity(n(), n(), n()))),
        lambda: repr(threewe.RangeData(n(), n(), n(), n())),
        lambda: threewe.Sample(draw.whole(), draw.whole(), n(), draw.scan()),
        lambda: threewe.OccupancyGrid(a(), n(), draw.place()),
        lambda: repr(draw.grid()) + str(draw.grid().cell(draw.place())) + str(draw.grid().at(draw.place())),
        lambda: threewe.Zone([draw.place() for _ in range(draw.randrange(5))], speed_limit=n()).contains(draw.place()),
        lambda: slam.save_map(draw.grid(), Path(tempfile.gettempdir()) / "threewe_extreme.yaml"),
        lambda: threewe.RobotProfile.load("3we_depth_v2").with_image_size(draw.whole(), draw.whole()),
        lambda: _core.unknown_name(draw.choice(OTHERS), draw.choice(OTHERS), draw.choice(OTHERS)),
    ]


def mapping(draw: Draw) -> list[Call]:
    """The mapper."""

    def config() -> slam.SlamConfig:
        fields = ["range_max", "resolution", "range_bias_sigma", "distance_sigma", "position_drift", "heading_drift"]
        return slam.SlamConfig(base_from_lidar=draw.pose(), **{name: draw.number() for name in draw.sample(fields, 1)})

    def drive(mapper: slam.Slam) -> object:
        for _ in range(4):
            odometry = draw.pose() if draw.random() < 0.5 else draw.fine()
            try:
                mapper.add(draw.scan(), odometry, None if draw.random() < 0.8 else draw.number())
            except threewe.ContractError:
                continue
        return mapper.map(), mapper.trajectory(), mapper.closures()

    return [
        lambda: drive(slam.Slam(config())),
        lambda: drive(slam.Slam()),
        lambda: drive(slam.Slam(slam.SlamConfig(base_from_lidar=threewe.Pose2D(draw.choice(NUMBERS), 0.0, 0.0)))),
        lambda: slam.relation_errors(draw.array(), slam.Relations(draw.array(), draw.array())),
        lambda: slam.LogSpec.load("office_loop").drive(draw.choice([-1, 2**64, None, 0.5])),
    ]


def scenes(draw: Draw) -> list[Call]:
    """Scenes, tables, exports."""
    scene = threewe.Scene.load("corridor_v1")
    profile = threewe.RobotProfile.load("3we_standard_v2")
    tables = threewe.SceneTables(scene, profile)
    meter = _core.CoverageMeter(scene, profile)
    sides = (6.0, 7.0, 40.0)
    folder = Path(tempfile.gettempdir()) / "threewe_extreme"
    return [
        lambda: threewe.Scene.generate(draw.whole(), difficulty=draw.number(), size=draw.place()),
        lambda: threewe.Scene.generate(draw.randrange(1000), size=(draw.choice(sides[:2]), draw.choice(sides[:2]))),
        lambda: threewe.Scene.load(draw.choice(OTHERS)),
        lambda: threewe.Scene.parse(draw.choice(OTHERS), draw.choice(OTHERS)),
        lambda: scene.to_yaml(draw.choice(OTHERS)),
        lambda: (scene.room_at(draw.place()), scene.friction_at(draw.place())),
        lambda: scene.room(draw.choice(OTHERS)),
        lambda: (tables.collides(draw.pose()), tables.clearance(draw.pose())),
        lambda: tables.geodesic(draw.place(), draw.place()),
        lambda: tables.sample_free_pose(draw.whole()),
        lambda: tables.sample_episode(draw.whole(), draw.whole()),
        lambda: meter.observe(draw.pose()),
        lambda: meter.coverage(draw.grid(), draw.pose()),
        lambda: threewe.export(scene, profile, draw.choice(["map", "urdf", *OTHERS]), folder),
    ]


def robots(draw: Draw) -> list[Call]:
    """A robot in a world."""
    robot = sync.Robot(scene="corridor_v1", noise="ideal")
    robot.connect()
    truth = robot.simulation
    assert truth is not None
    n, p = draw.number, draw.pose
    limit = {"timeout": 0.1}

    def world(**options: Any) -> object:
        return threewe.Robot(scene="corridor_v1", **options)

    return [
        lambda: world(start_pose=p()),
        lambda: world(initial_pose=p()),
        lambda: world(image_size=draw.choice([(draw.whole(), draw.whole()), draw.array(), *OTHERS])),
        lambda: world(seed=draw.whole()),
        lambda: world(map=draw.grid(), initial_pose=p()),
        lambda: world(randomization=draw.choice(OTHERS), noise=draw.choice(OTHERS)),
        lambda: threewe.World(scene="corridor_v1", start_poses=[p(), p()]),
        lambda: robot.move_to(n(), n(), n(), **limit),
        lambda: robot.move_to(draw.choice(NUMBERS), draw.choice(NUMBERS), **limit),
        lambda: robot.move_to(1.0, 0.0, tolerance=n(), angle_tolerance=n(), **limit),
        lambda: robot.move_forward(n(), tolerance=n(), **limit),
        lambda: robot.rotate(n(), angle_tolerance=n(), **limit),
        lambda: robot.follow_path(draw.choice([draw.array(), [draw.place(), draw.place()]]), tolerance=n(), **limit),
        lambda: robot.follow_waypoints([draw.place(), p()], tolerance=n(), angle_tolerance=n(), **limit),
        lambda: robot.explore(**limit),
        lambda: robot.set_velocity(n(), n(), n(), hold=n()),
        lambda: robot.execute_action(draw.choice([draw.array(), [n(), n(), n()]]), period=draw.choice([0.02, -1, "x"])),
        lambda: robot.sleep(draw.choice([0.0, 0.1, -1.0, math.nan, math.inf, 1e300, "x"])),
        lambda: robot.set_zones([threewe.Zone([draw.place() for _ in range(4)], speed_limit=n())]),
        lambda: robot.set_zones([]),
        lambda: robot.get_transform(draw.choice(OTHERS), draw.choice(OTHERS)),
        lambda: truth.look(threewe.CameraIntrinsics.of_view(32, 24, 1.0), p(), n()),
        lambda: truth.geodesic(draw.place(), draw.place()),
        lambda: truth.sample_free_pose(draw.whole()),
        lambda: truth.teleport(p()),
        lambda: truth.reset(seed=draw.whole(), pose=p(), episode=draw.whole()),
        lambda: truth.reset(),
        lambda: truth.restore(draw.choice([truth.save(), *OTHERS])),
    ]


def environments(draw: Draw) -> list[Call]:
    """Environments to learn in."""
    env = gym.Env(task="navigation", scene="corridor_v1")
    env.reset(seed=0)

    def options() -> dict[str, Any]:
        names = ["max_steps", "control_rate", "image_size", "min_distance", "max_distance", "success_radius", "scene"]
        return {name: draw.choice([draw.number(), draw.whole(), draw.array()]) for name in draw.sample(names, 1)}

    return [
        lambda: gym.Env(task="navigation", **options()),
        lambda: gym.Env(task=draw.choice(OTHERS), scene=draw.choice(OTHERS)),
        lambda: env.reset(seed=draw.whole(), options={"start": draw.choice([p.pose() for p in [draw]] + OTHERS)}),
        lambda: env.reset(options={"goal": draw.choice([draw.place(), draw.array()])}),
        lambda: env.reset(options={"episode_number": draw.whole(), "scene": draw.choice(["corridor_v1", *OTHERS])}),
        lambda: env.reset(options=draw.choice(OTHERS)),
        lambda: env.reset(seed=1),
        lambda: env.step(draw.choice([draw.array(), [draw.number()] * 3])),
    ]


def batches(draw: Draw) -> list[Call]:
    """Environments in a batch."""
    env = gym.VectorEnv(task="navigation", num_envs=2, scene="corridor_v1")
    env.reset(seed=0)
    others = [None, *OTHERS]

    def mask() -> Any:
        return draw.choice([np.array([True, False]), draw.array(), *others])

    return [
        lambda: gym.VectorEnv(task="navigation", num_envs=draw.choice([0, -1, 2**31, 2**63, 10**400, *others])),
        lambda: gym.VectorEnv(task="navigation", num_envs=1, num_threads=draw.whole(), scene="corridor_v1"),
        lambda: env.episode(draw.whole()),
        lambda: env.instruction(draw.whole()),
        lambda: env.randomization(draw.whole()),
        lambda: env.reset(seed=draw.choice([draw.whole(), [draw.whole(), draw.whole()], draw.array(), *others])),
        lambda: env.reset(options={"reset_mask": mask()}),
        lambda: env.reset(options={"episode_number": draw.choice([draw.whole(), [draw.whole(), draw.whole()]])}),
        lambda: env.reset(options={"start": draw.place(), "goal": draw.array()}),
        lambda: env.reset(seed=1),
        lambda: env.step(draw.choice([draw.array(), [[draw.number()] * 3] * 2, *others])),
    ]


GROUPS: dict[str, Callable[[Draw], list[Call]]] = {
    function.__name__: function for function in (values, mapping, scenes, robots, environments, batches)
}


def main(group: str, seed: int, count: int) -> int:
    """Makes calls; what one may raise is a ThreeweError, TypeError or ValueError."""
    draw = Draw(seed)
    calls = GROUPS[group](draw)
    for i in range(count):
        which = draw.randrange(len(calls))
        draw.seed(f"{seed} {i}")
        print(f"{group} {seed}: call {i} of function {which}", file=sys.stderr, flush=True)
        faulthandler.dump_traceback_later(2 * LIMIT, exit=True)
        try:
            calls[which]()
        except (threewe.ThreeweError, TypeError, ValueError):
            continue
        except asyncio.CancelledError:
            raise
        finally:
            faulthandler.cancel_dump_traceback_later()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3])))
