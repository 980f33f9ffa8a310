"""A stand-in for a robot on ROS 2, in a process of its own on Fast DDS: see tests/ros2/robot.cpp."""

import json
import math
import os
import signal
import subprocess
import time
from types import TracebackType
from typing import Any, Self

import threewe
import threewe.sync
from threewe import Pose2D, RobotProfile, Scene, SceneTables
from threewe.testing import check_backend

from verify.cases.trees import ROOT
from verify.harness import Case

PROGRAM = ROOT / "build/dev/tests/ros2/ros2_robot"
HARDWARE = "3we_standard_v2"
MISSING = {"not_shown": "the stand-in needs libfastrtps-dev and fastddsgen"}
FARTHEST = 3.0
"""[m] of a drive's shortest path: all is in real time."""
CUTS = 2
"""Of each case: finding each other takes seconds."""


class StandIn:
    """One that runs inside `with`, in a ROS domain of its own; afterwards `truth` is what it stated in the end."""

    def __init__(self, *options: str) -> None:
        domain = 1 + os.getpid() % 100
        os.environ["ROS_DOMAIN_ID"] = str(domain)
        self.command = [str(PROGRAM), str(domain), *options]
        self.truth: dict[str, Any] = {}

    def __enter__(self) -> Self:
        self.process = subprocess.Popen(self.command, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout is not None
        if self.process.stdout.readline() != "ready\n":
            raise RuntimeError(f"{self.command} did not begin")
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.process.terminate()
        self.truth = json.loads(self.process.communicate(timeout=30)[0])


def keep_the_contract(seed: int, check: str) -> Case:
    """One check of the contract over the stand-in."""
    if not PROGRAM.exists():
        return MISSING
    with StandIn("--seed", str(seed % 1000)):
        (result,) = check_backend("real", hardware=HARDWARE, checks=[check], show=False)
    return {"outcome": result.outcome.name, "detail": result.detail}


def drive_over_a_bad_link(seed: int, scene: str) -> Case:
    """A near goal, over a link that delays, reorders and loses messages, and by the embedded simulator."""
    if not PROGRAM.exists():
        return MISSING
    tables = SceneTables(Scene.load(scene), RobotProfile.load(HARDWARE))
    drawn = (tables.sample_episode(seed, number) for number in range(1000))
    episode = next(one for one in drawn if one.geodesic <= FARTHEST)
    goal = episode.start.inverse() * Pose2D(*episode.goal, 0.0)

    def arrived(pose: Pose2D, result: threewe.MoveResult) -> bool:
        return result.success and math.hypot(pose.x - goal.x, pose.y - goal.y) <= 0.25

    start = episode.start
    link = ["--delay", "0.02", "--jitter", "0.01", "--loss", "0.01"]
    place = ["--scene", scene, "--pose", f"{start.x},{start.y},{start.theta}", "--seed", str(seed % 2**31)]
    with StandIn(*place, *link) as robot_process, threewe.sync.Robot("real", HARDWARE) as robot:
        result = robot.move_to(goal.x, goal.y)
        robot.sleep(0.5)
        robot_process.process.terminate()  # while it is still there: it returns to its start once it is let go
        robot_process.process.wait(30)
    with threewe.sync.Robot("mock", HARDWARE, scene, seed=seed, start_pose=start) as simulated:
        reference = simulated.move_to(goal.x, goal.y)
        simulated.sleep(0.5)
        assert simulated.simulation is not None
        there = start.inverse() * simulated.simulation.true_pose()
    truth = robot_process.truth
    return {
        "scene": scene,
        "arrived": arrived(Pose2D(*truth["pose"]), result),
        "reason": result.reason.name,
        "contact_speed": truth["max_collision_speed"],
        "mock_arrived": arrived(there, reference),
    }


def cut_the_link(seed: int) -> Case:
    """Drives while the link is cut at random instants, and is mended a second later."""
    if not PROGRAM.exists():
        return MISSING
    noticed: list[float] = []
    with StandIn("--seed", str(seed % 2**31)) as robot_process, threewe.sync.Robot("real", HARDWARE) as robot:
        for number in range(CUTS):
            robot.set_velocity(0.0, 0.0, 0.4 if number % 2 == 0 else -0.4, hold=60.0)
            robot.sleep(0.6 + (seed * (number + 1)) % 97 / 200)  # not in step with anything
            robot_process.process.send_signal(signal.SIGUSR1)
            begin = time.monotonic()
            while all(sensor.ok for sensor in robot.health.values()) and time.monotonic() - begin < 2.0:
                robot.sleep(0.02)
            noticed.append(time.monotonic() - begin)
            robot.sleep(0.5)
            robot_process.process.send_signal(signal.SIGUSR2)
            robot.sleep(1.0)
            robot.stop()
            robot.sleep(0.5)
    cuts = robot_process.truth["cuts"]
    return {"cuts": [{**cut, "noticed": after} for cut, after in zip(cuts, noticed, strict=True)]}
