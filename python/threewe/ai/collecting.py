"""Demonstrations: a teacher does in simulation what an instruction says, and the recorder writes a LeRobot dataset.

Tasks are `goto` (to a thing that is in view), and those of the benchmarks `objectnav` (to one that is elsewhere) and
`vln`. The teachers are the navigator, which knows where the goal is, and `execute_instruction`, which does not.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from threewe._core import (
    DriveLog,
    Object,
    ObjectNav,
    Pose2D,
    RobotProfile,
    SceneTables,
    Vln,
    VlnEpisode,
    unknown_name,
)
from threewe.ai.runner import VLARunner
from threewe.benchmark.attempt import rooms_of
from threewe.benchmark.buildings import building_name, scene_asset
from threewe.benchmark.varied import varied_building
from threewe.data.exporting import export
from threewe.data.recorder import TrajectoryRecorder
from threewe.data.recording import DISTURBED, Recording, spans_to_text
from threewe.errors import ConfigError
from threewe.robot import Robot
from threewe.simulation import Simulation

IMAGES = {"navigator": (60, 80), "instruction": (240, 320)}
"""(height, width) [px] of what is recorded unless said; the detector, by which instructions are carried out, needs
larger ones"""
FPS = 10
PER_ROBOT = {"navigator": 10, "instruction": 1}
"""drives of a robot in one scene: a teacher that looks for things would remember them from the drive before"""
TASKS = {"goto": 60.0, "objectnav": 300.0, "vln": 300.0}
"""[s] of a drive, at most"""
STANDS_FROM = (0.55, 0.7, 0.85)  # [m] from a thing's nearest side to where the robot stops, the first that shows it
TURNS = (0.0, 0.35, -0.35, 0.7, -0.7)  # [rad] about the thing, from the straight way to it
SHOWN = 0.002  # of the picture, at least, that shows it in the end
ROOM = 0.08  # [m] around the robot there, whichever way it turns
LONGEST = {"goto": 12.0, "objectnav": 40.0}  # [m] of the way
STANDS_FOR = 1.0  # [s] that are recorded in the end
TRIES = 200
CALM = (0.5, 5.0)  # [s] before a burst of random commands
BURST = (0.4, 1.6)  # [s] that it lasts
BURSTS = 3  # of a drive, at most
POLICY_DRIVES = (1.0, 12.0)  # [s] in the navigator's place, unless it stands still before


@dataclass(frozen=True)
class Collection:
    """How demonstrations are made."""

    task: str = "goto"
    teacher: str = "navigator"
    scene: str = "procedural"
    """a name, a file, or in one building after the other, ten drives of the navigator each: `procedural` are generated
    ones of all sizes, in `varied` ones more and other things stand"""
    backend: str = "mock"
    hardware: str = "3we_standard_v2"
    randomization: str = "none"
    disturbance: str = "random"
    """takes the robot off the navigator's way, and is marked as `disturbed`: `random` bursts of commands, `none`, or a
    policy that drives for a while: the navigator shows the way from where that one goes (DAgger, Ross et al. 2011)"""
    seed: int = 0
    image_size: tuple[int, int] | None = None
    """(height, width) [px]"""

    def __post_init__(self) -> None:
        for what, name, known in (("task", self.task, TASKS), ("teacher", self.teacher, PER_ROBOT)):
            if name not in known:
                raise ConfigError(unknown_name(what, name, list(known)))
        if self.teacher != "navigator" and self.policy:
            raise ConfigError(f"disturbance: {self.policy} can drive in the navigator's place alone; leave it out")

    @property
    def policy(self) -> str:
        """That disturbs; empty where none does."""
        return "" if self.disturbance in ("random", "none") else self.disturbance


@dataclass(frozen=True)
class _Drive:
    """What a drive is to do, as drawn."""

    index: int
    start: Pose2D
    kind: str = ""  # of the thing that it leads to
    vln: VlnEpisode | None = None

    @property
    def instruction(self) -> str:
        return self.vln.instruction if self.vln is not None else f"go to the {self.kind}"


_Target = tuple[float, float, float | None]
"""x, y [m], theta [rad] if any, in `map`"""


async def collect_demonstrations(output: Path, episodes: int, how: Collection) -> int:
    """Writes a LeRobot dataset of `episodes` drives; how many arrived. Raises ConfigError."""
    if output.exists():
        raise ConfigError(f"output: {output} exists already")
    policy = VLARunner.from_pretrained(how.policy) if how.policy else None
    done = arrived = 0
    with TemporaryDirectory() as folder:
        journals, buildings = Path(folder, "journals"), Path(folder, "buildings")
        for number, scene in enumerate(_scenes(how, buildings)):
            wanted = min(PER_ROBOT[how.teacher], episodes - done)
            drives = await _collect_in(scene, wanted, how, number, journals, policy)
            done, arrived = done + len(drives), arrived + sum(drives)
            if done == episodes:
                break
            if done == 0 and number == TRIES:
                raise ConfigError(f"scene: nothing to do for {how.task} from any of many places in {scene}")
        export(Recording(journals), output, format="lerobot", fps=FPS)
    return arrived


def _scenes(how: Collection, folder: Path) -> Iterator[str]:
    for number in count():
        if how.scene == "procedural":
            yield scene_asset(building_name(f"collect/{how.seed}/{number}"))
        elif how.scene == "varied":
            path = folder / str(number) / "building.yaml"
            path.parent.mkdir(parents=True)
            random = np.random.default_rng([how.seed, number])
            path.write_text(varied_building(random, how.seed * 100_003 + number), encoding="utf-8")
            yield str(path)
        else:
            yield how.scene


async def _collect_in(
    scene: str, episodes: int, how: Collection, number: int, journals: Path, policy: VLARunner | None
) -> list[bool]:
    """Whether each drive arrived; there are fewer where the scene has too few tasks."""
    seed = how.seed * 100_003 + number
    random = np.random.default_rng(seed)
    profile = RobotProfile.load(how.hardware)
    robot = Robot(
        how.backend,
        how.hardware,
        scene,
        seed=seed,
        localization="truth",
        image_size=how.image_size or IMAGES[how.teacher],
        randomization=how.randomization,
    )
    drives: list[bool] = []
    async with robot:
        assert robot.simulation is not None
        try:
            tables = SceneTables(robot.simulation.scene, profile)
            task = Vln(tables) if how.task == "vln" else ObjectNav(tables, profile)
        except ConfigError:  # there is nothing to do
            return []
        with TrajectoryRecorder(robot, journals, sensors=["camera"]) as recorder:
            for drive in _draw(task, how.task, seed, random, 3 * episodes):
                if len(drives) == episodes:
                    break
                robot.simulation.reset(seed=seed, episode=drive.index, pose=drive.start)
                if how.teacher == "instruction":
                    drives.append(await _instruct(robot, recorder, scene, task, drive, TASKS[how.task]))
                    continue
                target = _target(robot.simulation, tables, profile, drive, LONGEST.get(how.task, math.inf))
                if target is None:
                    continue
                recorder.start_episode(drive.instruction)
                disturbed = [] if how.disturbance == "none" else await _disturb(robot, target, drive, random, policy)
                result = await robot.move_to(*target, timeout=TASKS[how.task])
                await robot.sleep(STANDS_FOR)
                kept = {"reason": str(result.reason), DISTURBED: spans_to_text(disturbed)}
                recorder.end_episode(success=result.success, metadata=kept)
                drives.append(result.success)
    return drives


def _draw(task: ObjectNav | Vln, name: str, seed: int, random: np.random.Generator, tries: int) -> Iterator[_Drive]:
    """Drives in a scene, fewer where no kind of things is left."""
    if isinstance(task, Vln):
        for index in range(tries):
            episode = task.sample(seed, index)
            yield _Drive(index, episode.start, vln=episode)
        return
    kinds = [kind for kind in task.goals if kind != "door"]
    sample = task.sample_in_sight if name == "goto" else task.sample
    for index in range(tries):
        if not kinds:
            return
        kind = kinds[int(random.integers(len(kinds)))]
        try:
            start = sample(seed, index, kind).start
        except ConfigError:
            kinds.remove(kind)
            continue
        yield _Drive(index, start, kind)


async def _instruct(
    robot: Robot, recorder: TrajectoryRecorder, scene: str, task: ObjectNav | Vln, drive: _Drive, limit: float
) -> bool:
    """A drive of `execute_instruction`, without a model; whether it arrived in truth."""
    simulation = robot.simulation
    assert simulation is not None
    if drive.vln is not None:
        for name, border in rooms_of(scene, simulation.scene_from_map.inverse()):
            robot.name_place(name, border)
    log = DriveLog(robot._world)
    recorder.start_episode(drive.instruction)
    result = await robot.execute_instruction(drive.instruction, timeout=limit, model="")
    await robot.sleep(STANDS_FOR)
    log.end()
    if isinstance(task, Vln):
        assert drive.vln is not None
        there = simulation.true_pose()
        arrived = task.is_success(drive.vln, (there.x, there.y))
    else:
        arrived = bool(task.found(robot.profile, drive.kind, log))
    success = arrived and result.success
    recorder.end_episode(success=success, metadata={"reason": str(result.reason), DISTURBED: spans_to_text([])})
    return success


async def _disturb(
    robot: Robot, target: _Target, drive: _Drive, random: np.random.Generator, policy: VLARunner | None
) -> list[tuple[float, float]]:
    """On the way to a target: when it was not the navigator that drove [s]."""
    spans: list[tuple[float, float]] = []
    for number in range(int(random.integers(BURSTS + 1))):
        calm = 0.0 if policy and number == 0 else random.uniform(*CALM)
        begin = robot.now + calm
        if calm and (await robot.move_to(*target, timeout=calm)).reason != "timeout":
            break
        if policy:
            await policy.run(robot, drive.instruction, timeout=random.uniform(*POLICY_DRIVES))
        else:
            await _burst(robot, random)
        spans.append((begin, robot.now))  # braking was no wish of the navigator either
    return spans


async def _burst(robot: Robot, random: np.random.Generator) -> None:
    """Random commands, as long as a burst lasts."""
    seconds = random.uniform(*BURST)
    limits = robot.profile.operating_limits
    vx, vy = random.uniform(-0.6, 1.0) * limits.linear, random.uniform(-0.8, 0.8) * limits.linear
    sideways = robot.profile.kinematics.name == "holonomic"
    robot.set_velocity(vx, vy if sideways else 0.0, random.uniform(-1.0, 1.0) * limits.angular, hold=seconds)
    await robot.sleep(seconds)


def _target(
    simulation: Simulation, tables: SceneTables, profile: RobotProfile, drive: _Drive, longest: float
) -> _Target | None:
    """Where the navigator is to stop; None where there is no such place."""
    map_from_scene = simulation.scene_from_map.inverse()
    if drive.vln is not None:
        there = map_from_scene * Pose2D(*drive.vln.end, 0.0)
        return there.x, there.y, None
    goal = _goal(simulation, tables, profile, drive.kind, longest)
    if goal is None:
        return None
    there = map_from_scene * goal
    return there.x, there.y, there.theta


def _goal(
    simulation: Simulation, tables: SceneTables, profile: RobotProfile, kind: str, longest: float
) -> Pose2D | None:
    """Where to stop before the thing of a kind that is seen best, or is nearest: turned to it, and so that it is seen.

    None where the shortest path is longer [m].
    """
    start, seen = simulation.true_pose(), simulation.look()
    pixels = {name: int(np.sum(seen.ids == i)) for i, name in enumerate(seen.names)}
    things = [thing for thing in simulation.scene.objects if thing.category == kind]

    def seen_and_near(one: Object) -> tuple[int, float]:
        return pixels.get(one.name, 0), -math.hypot(one.pose.x - start.x, one.pose.y - start.y)

    thing = max(things, key=seen_and_near)
    assert profile.camera is not None
    away = math.atan2(start.y - thing.pose.y, start.x - thing.pose.x)
    for near in STANDS_FROM:
        for turn in TURNS:
            goal = _before(thing, away + turn, near)
            if not simulation.geodesic(start, goal) < longest or _room(tables, goal) < ROOM:
                continue
            picture = simulation.look(pose=goal * profile.camera.base_from_camera, with_itself=False)
            if np.mean(picture.ids == list(picture.names).index(thing.name)) >= SHOWN:
                return goal
    return None


def _room(tables: SceneTables, place: Pose2D) -> float:
    """[m] to the nearest obstacle, in the worst of sixteen headings."""
    return min(tables.clearance(Pose2D(place.x, place.y, k * math.pi / 8)) for k in range(16))


def _before(thing: Object, direction: float, near: float) -> Pose2D:
    """The pose so far [m] from a thing's nearest side, in a direction from its middle, turned to it."""
    cosine, sine = math.cos(direction), math.sin(direction)
    corners = [thing.pose * Pose2D(x, y, 0.0) for prism in thing.prisms for x, y in prism.outline()]
    outer = max((c.x - thing.pose.x) * cosine + (c.y - thing.pose.y) * sine for c in corners)
    radius = outer + near
    return Pose2D(thing.pose.x + radius * cosine, thing.pose.y + radius * sine, math.atan2(-sine, -cosine))
