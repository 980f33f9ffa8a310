"""A stand-in for a robot on ROS 2, in a process of its own on Fast DDS: see tests/ros2/robot.cpp."""

import asyncio
import json
import math
import os
import signal
import subprocess
import tempfile
import time
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import threewe
import threewe.sync
from threewe import Pose2D, RobotProfile, Scene, SceneTables
from threewe.testing import check_backend

from verify.cases.trees import ROOT
from verify.harness import Case

PROGRAM = ROOT / "build/dev/tests/ros2/ros2_robot"
NAV2 = ROOT / "build/dev/tests/ros2/ros2_nav2"
HARDWARE = "3we_standard_v2"
MISSING = {"not_shown": "the stand-in needs libfastrtps-dev and fastddsgen"}
ROBOTS = {
    "micro-ROS": ((), ()),
    "TurtleBot 4": (
        ("--turtlebot4",),
        (
            (
                "odometry: {topic: /odom, type: nav_msgs/msg/Odometry}",
                "odometry: {topic: /tf, type: tf2_msgs/msg/TFMessage}",
            ),
            ("geometry_msgs/msg/Twist}", "geometry_msgs/msg/TwistStamped}"),
            (
                "  command: {topic",
                "    camera: {topic: /camera/image_raw/compressed, type: sensor_msgs/msg/CompressedImage}\n"
                "  command: {topic",
            ),
        ),
    ),
}
"""Options of the stand-in, and changes to the profile's link: odometry in /tf alone, JPEGs, stamped velocities."""
FARTHEST = 6.0
"""[m] of a drive's shortest path: all is in real time."""
CUTS = 20
"""Of each case: finding each other takes seconds."""
NEEDED = ("lidar", "imu", "odometry")
"""Sensors without which a robot stands."""
PARTS = 10
"""Of the outcomes of delegated goals, with 23 each."""
CODES = {
    "lost": [102, 202, 302, 702, 712, 722, 9002],
    "no_path": [103, 203, 204, 206, 207, 208, 303, 304, 306, 307, 308, 309, 502, 505, 602],
    "blocked": [104, 105, 106, 205, 305, 503, 603, 701, 703, 711, 714, 721, 723, 741],
    "timeout": [108, 9003],
    "fault": [
        *(1, 2, 100, 101, 107, 200, 201, 300, 301, 500, 501, 504),
        *(600, 601, 700, 710, 713, 720, 724, 740, 9000, 9001, 12345),
    ],
    "cancelled": [0],
}
"""What each error code of Nav2's is to us; 12345 is none of its own."""


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


def keep_the_contract(seed: int, check: str, robot: str) -> Case:
    """One check of the contract over the stand-in, which plays one of `ROBOTS`."""
    if not PROGRAM.exists():
        return MISSING
    options, changes = ROBOTS[robot]
    yaml = RobotProfile.load(HARDWARE).yaml
    for old, new in changes:
        assert old in yaml
        yaml = yaml.replace(old, new)
    with tempfile.TemporaryDirectory() as folder, StandIn(*options, "--seed", str(seed % 1000)):
        profile = Path(folder) / "robot.yaml"
        profile.write_text(yaml)
        (result,) = check_backend("real", hardware=str(profile), checks=[check], show=False)
    return {"robot": robot, "check": check, "outcome": result.outcome.name, "detail": result.detail}


def drive_over_a_bad_link(seed: int, scene: str) -> Case:
    """One goal over a link that delays, reorders and loses messages, and by the embedded simulator."""
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
    """Drives while the link is cut at random instants, and is mended half a second later."""
    if not PROGRAM.exists():
        return MISSING
    noticed: list[float] = []
    with StandIn("--seed", str(seed % 2**31)) as robot_process, threewe.sync.Robot("real", HARDWARE) as robot:
        for number in range(CUTS):
            forward, turn = [(0.0, 0.4), (0.0, -0.4), (0.2, 0.0), (-0.2, 0.0)][number % 4]
            robot.set_velocity(forward, 0.0, turn, hold=60.0)
            robot.sleep(0.5 + (seed * (number + 1)) % 97 / 200)  # not in step with anything
            robot_process.process.send_signal(signal.SIGUSR1)
            begin = time.monotonic()
            while all(robot.health[name].ok for name in NEEDED) and time.monotonic() - begin < 2.0:
                robot.sleep(0.02)
            noticed.append(time.monotonic() - begin)
            robot.sleep(0.3)
            robot_process.process.send_signal(signal.SIGUSR2)
            robot.sleep(0.8)
            robot.stop()
    cuts = robot_process.truth["cuts"]
    return {"cuts": [{**cut, "noticed": after} for cut, after in zip(cuts, noticed, strict=True)]}


class Nav2:
    """A stand-in for Nav2 and SLAM Toolbox that runs inside `with`: see tests/ros2/nav2.cpp."""

    def __enter__(self) -> Self:
        command = [str(NAV2), os.environ["ROS_DOMAIN_ID"]]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout is not None
        if self.process.stdout.readline() != "ready\n":
            raise RuntimeError(f"{command} did not begin")
        return self

    def set(self, mode: str) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(f"{mode}\n")
        self.process.stdin.flush()

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.asked = json.loads(self.process.communicate(timeout=30)[0].splitlines()[-1])


def delegate(seed: int, part: int) -> Case:
    """23 goals for the stand-in for Nav2, which treats each as it is asked to: did what it did arrive?"""
    if not NAV2.exists():
        return MISSING
    codes = [(f"fail {code}", "to", reason) for reason, numbers in CODES.items() for code in numbers]
    goals = [
        *[("normal", "to", "reached")] * 3,
        *[("normal", "along", "reached")] * 2,
        ("normal", "visit", "reached"),
        *[("normal", "to, stop", "cancelled")] * 2,
        ("normal", "visit, stop", "cancelled"),
        ("fail 106", "along", "blocked"),
        ("fail 208", "visit", "no_path"),
        ("miss 105", "visit", "blocked"),
        ("reject", "to", "fault"),
        ("cancel", "to", "cancelled"),
        ("slow 1", "to", "reached"),
        ("deaf" if part % 2 else "mute", "to", "fault"),
        *[codes[(7 * part + number) % len(codes)] for number in range(7)],
    ]
    with StandIn("--truth", "--seed", str(seed % 1000)), Nav2() as nav2:
        results = asyncio.run(_drive(nav2, [(mode, how) for mode, how, _ in goals]))
    silent = part % 2 == 0  # one that was cancelled as it said nothing of itself any more
    return {
        "goals": [
            {"mode": mode, "how": how, "expected": expected, "reason": result.reason.name, "detail": result.detail}
            for (mode, how, expected), result in zip(goals, results, strict=True)
        ],
        "cancelled": nav2.asked["cancelled"],
        "to_cancel": sum(how.endswith("stop") for _, how, _ in goals) + silent,
    }


async def _drive(nav2: Nav2, goals: list[tuple[str, str]]) -> list[threewe.MoveResult]:
    results = []
    async with threewe.Robot("real", HARDWARE, localization="slam_toolbox", navigation="nav2") as robot:
        for mode, how in goals:
            nav2.set(mode)
            await robot.sleep(0.1)
            x = 1.0 if robot.get_pose().x < 0.5 else 0.0
            motions = {
                "to": lambda x: robot.move_to(x, 0.0),
                "along": lambda x: robot.follow_path([(x, 0.0)]),
                "visit": lambda x: robot.follow_waypoints([(0.5, 0.0), (x, 0.0)]),
            }
            task = asyncio.ensure_future(motions[how.removesuffix(", stop")](x))
            if how.endswith("stop"):
                await robot.sleep(0.6)
                robot.stop()
            results.append(await task)
            await robot.sleep(0.3)
    return results
