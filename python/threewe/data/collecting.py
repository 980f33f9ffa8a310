"""Collection of episodes: drives of the robot's own to goals drawn at random, of a person, and of both in turn."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from threewe._console import plain_console
from threewe._core import Pose2D
from threewe.data.recorder import TrajectoryRecorder
from threewe.errors import ConfigError
from threewe.robot import Robot
from threewe.teleop.session import InputKind, drive_by_hand

LEAST = 1.0
"""[m] of the shortest path to a goal that is worth an episode."""


def goals(robot: Robot, seed: int) -> Iterator[Pose2D]:
    """Free poses in the robot's `map`, each far enough from where it stands when it is asked for, without end."""
    simulation = robot.simulation
    if simulation is None:
        raise ConfigError("goals are drawn in simulated worlds alone: drive this robot yourself, with --driver person")
    drawn = 0
    while True:
        goal = simulation.sample_free_pose(seed * 1_000_003 + drawn)
        drawn += 1
        if LEAST <= simulation.geodesic(simulation.true_pose(), goal) < float("inf"):
            yield simulation.scene_from_map.inverse() * goal


async def collect(
    output: Path, episodes: int, backend: str, hardware: str, scene: str, seed: int, task: str
) -> tuple[str, tuple[str, str]]:
    """Records `episodes` drives of a simulated robot into `output`; what came of it, in words."""
    reached = 0
    async with Robot(backend=backend, hardware=hardware, scene=scene, seed=seed) as robot:
        drawn = goals(robot, seed)
        with (
            TrajectoryRecorder(robot, output) as recorder,
            Progress(console=plain_console(stderr=True), transient=True) as bar,
        ):
            for _ in bar.track(range(episodes), description="recording"):
                goal = next(drawn)
                recorder.start_episode(task, {"goal_x": goal.x, "goal_y": goal.y, "scene": scene})
                result = await robot.move_to(goal.x, goal.y)
                recorder.end_episode(success=result.success, metadata={"reason": str(result.reason)})
                reached += result.success
    return f"{reached} of {episodes} goals reached; the journals are in ", (f"{output}/", "bold")


async def drive(
    output: Path,
    backend: str,
    hardware: str,
    scene: str,
    seed: int,
    task: str,
    console: Console,
    kind: InputKind,
    device: Path | None,
    *,
    by_itself: bool,
) -> int:
    """Lets a person drive and say what is an episode; `by_itself` lets the robot drive to random goals until the person
    takes over. How many episodes were kept."""
    robot = Robot(backend=backend, hardware=hardware, scene=scene, seed=seed, realtime=True)

    async def go() -> None:
        for goal in goals(robot, seed):
            await robot.move_to(goal.x, goal.y)

    with TrajectoryRecorder(robot, output) as recorder:
        return await drive_by_hand(
            robot,
            console,
            f"{hardware} in {scene} on {backend}, recorded into {output}/",
            kind,
            device,
            recorder=recorder,
            autonomy=go if by_itself else None,
            task=task,
        )
