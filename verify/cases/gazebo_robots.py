"""A stand-in for Gazebo, in a process of its own on Gazebo's transport: see tests/gazebo/simulator.cpp."""

import math
import os
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import threewe.sync
from threewe import Pose2D, RobotProfile, Scene, SceneTables
from threewe.gazebo import write_world
from threewe.testing import check_backend

from verify.cases.trees import ROOT
from verify.harness import Case

PROGRAM = ROOT / "build/dev/tests/gazebo/gazebo_simulator"
MISSING = {"not_shown": "the stand-in needs libignition-transport-dev, libsdformat-dev and protobuf-compiler"}


@contextmanager
def stand_in(scene: str, hardware: str, seed: int) -> Iterator[None]:
    """One that runs inside `with`, in a partition of its own."""
    partition = f"threewe_verify_{os.getpid()}"
    os.environ["GZ_PARTITION"] = partition
    with tempfile.TemporaryDirectory() as folder:
        world = write_world(scene, hardware, Path(folder))
        command = [str(PROGRAM), str(world), "-r", "--seed", str(seed % 2**31)]
        environment = os.environ | {"IGN_PARTITION": partition}
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as process:
            assert process.stdout is not None
            if process.stdout.readline() != "ready\n":
                raise RuntimeError(f"{command} did not begin")
            try:
                yield
            finally:
                process.terminate()


def keep_the_contract(seed: int, check: str, hardware: str) -> Case:
    """One check of the contract over the stand-in."""
    if not PROGRAM.exists():
        return MISSING
    with stand_in("office_v2", hardware, seed):
        (result,) = check_backend("gazebo", hardware=hardware, checks=[check], show=False)
    return {"outcome": result.outcome.name, "detail": result.detail}


def drive(seed: int, scene: str) -> Case:
    """An episode's goal, in the stand-in and in the embedded simulator."""
    if not PROGRAM.exists():
        return MISSING
    hardware = "3we_standard_v2"
    episode = SceneTables(Scene.load(scene), RobotProfile.load(hardware)).sample_episode(seed, 0)
    goal = episode.start.inverse() * Pose2D(*episode.goal, 0.0)
    arrived = []
    speeds = []
    with stand_in(scene, hardware, seed):
        for backend in ("gazebo", "mock"):
            with threewe.sync.Robot(backend, hardware, scene, seed=seed, start_pose=episode.start) as robot:
                result = robot.move_to(goal.x, goal.y)
                robot.sleep(0.5)
                assert robot.simulation is not None
                there = episode.start.inverse() * robot.simulation.true_pose()
                arrived.append(result.success and math.hypot(there.x - goal.x, there.y - goal.y) <= 0.25)
                speeds.append(robot.simulation.max_collision_speed())
    return {"scene": scene, "arrived": arrived[0], "mock_arrived": arrived[1], "contact_speed": speeds[0]}
