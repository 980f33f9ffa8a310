"""The main job: a robot wakes up knowing nothing, explores, draws its map and drives to a named place."""

from __future__ import annotations

import json
import math
import time
from dataclasses import asdict, dataclass
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TimeElapsedColumn
from rich.table import Table

import threewe
from threewe import CoverageMeter, Robot, TickView
from threewe._console import plain_column
from threewe.film import Film


@dataclass
class Summary:
    """What `summary.json` holds. Lengths in metres, times in seconds."""

    version: str
    scene: str
    hardware: str
    seed: int
    place: str
    explored: bool
    explore_reason: str
    arrived: bool
    move_reason: str
    true_distance_to_place: float
    coverage: float
    distance_driven: float
    localisation_error_mean: float
    localisation_error_max: float
    max_collision_speed: float
    robot_seconds: float
    wall_seconds: float


class Referee:
    """Compares the robot's belief with the truth, which the robot itself never sees."""

    LOOK_EVERY = 0.2  # [s]
    MEASURE_EVERY = 2.0  # [s], of the coverage, which takes longer

    def __init__(self, robot: Robot) -> None:
        assert robot.simulation is not None
        self._robot = robot
        self._truth = robot.simulation
        self._meter = CoverageMeter(self._truth)
        self._errors: list[float] = []
        self._looked = self._measured = -math.inf
        self._observer = robot.observe(self._look)
        self.coverage = 0.0

    def close(self) -> None:
        """Stops watching."""
        self._robot.unobserve(self._observer)

    def measure(self) -> float:
        """The coverage as it is now."""
        self.coverage = self._meter.coverage(self._robot.get_map())
        return self.coverage

    @property
    def error_mean(self) -> float:
        """Of the believed position [m]."""
        return sum(self._errors) / len(self._errors)

    @property
    def error_max(self) -> float:
        """Of the believed position [m]."""
        return max(self._errors)

    def _look(self, tick: TickView) -> None:
        if tick.now - self._measured > self.MEASURE_EVERY:
            self._measured = tick.now
            self.measure()
        if tick.now - self._looked < self.LOOK_EVERY:
            return
        self._looked = tick.now
        true, believed = self._truth.true_pose(), self._robot.get_pose()
        self._meter.observe(true)
        self._errors.append(math.hypot(true.x - believed.x, true.y - believed.y))


async def run(scene: str, hardware: str, place: str, seed: int, output: Path, console: Console) -> Summary:
    """Explores `scene`, drives to the room `place`, and leaves pictures, films and `summary.json` in `output`."""
    started = time.perf_counter()
    output.mkdir(parents=True, exist_ok=True)
    columns = (
        plain_column("{task.description:<22}"),
        BarColumn(32),
        plain_column("{task.fields[figures]}"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console) as bar:
        async with Robot(scene=scene, hardware=hardware, seed=seed) as robot:
            truth = robot.simulation
            assert truth is not None
            goal = truth.scene.room(place).anchor
            referee, film = Referee(robot), Film(robot)

            film.status = "exploring"
            task = bar.add_task("exploring", total=1.0, figures="")

            def look(_: threewe.Progress) -> None:
                film.coverage = referee.coverage
                figures = f"{100 * film.coverage:3.0f} % seen, {robot.now:4.0f} robot s"
                bar.update(task, completed=film.coverage, figures=figures)

            explored = await robot.explore(timeout=600.0, on_progress=look)
            coverage = referee.measure()
            bar.update(task, completed=1.0)

            film.status = f"driving to the {place.replace('_', ' ')}"
            task = bar.add_task(film.status, total=1.0, figures="")
            moved = await robot.move_to(*goal)
            figures = f"{moved.reason.name} after {moved.duration:.0f} robot s"
            bar.update(task, completed=1.0, figures=figures)
            await robot.sleep(0.5)
            film.close()
            referee.close()

            task = bar.add_task("drawing the film", total=1.0, figures=f"{len(film.states)} states")
            film.save(output, lambda done: bar.update(task, completed=done))
            pose = truth.true_pose()
            summary = Summary(
                version=threewe.__version__,
                scene=scene,
                hardware=hardware,
                seed=seed,
                place=place,
                explored=explored.success,
                explore_reason=explored.reason.name,
                arrived=moved.success,
                move_reason=moved.reason.name,
                true_distance_to_place=math.hypot(pose.x - goal[0], pose.y - goal[1]),
                coverage=coverage,
                distance_driven=truth.distance_driven(),
                localisation_error_mean=referee.error_mean,
                localisation_error_max=referee.error_max,
                max_collision_speed=truth.max_collision_speed(),
                robot_seconds=robot.now,
                wall_seconds=time.perf_counter() - started,
            )
    (output / "summary.json").write_text(json.dumps(asdict(summary), indent=2) + "\n")
    console.print(_table(summary))
    return summary


def _table(s: Summary) -> Table:
    off = f"{s.true_distance_to_place:.2f} m off in truth"
    error = f"{100 * s.localisation_error_mean:.1f} cm mean, {100 * s.localisation_error_max:.1f} cm most"
    contacts = "none" if s.max_collision_speed == 0.0 else f"hardest at {s.max_collision_speed:.3f} m/s"
    table = Table(title=f"{s.hardware} in {s.scene}, seed {s.seed}", show_header=False, title_justify="left")
    table.add_row("coverage", f"{100 * s.coverage:.1f} %")
    table.add_row(f"drive to the {s.place.replace('_', ' ')}", f"{s.move_reason}, {off}")
    table.add_row("distance driven", f"{s.distance_driven:.1f} m")
    table.add_row("true localisation error", error)
    table.add_row("contacts", contacts)
    table.add_row("robot time", f"{s.robot_seconds:.0f} s")
    table.add_row("wall time", f"{s.wall_seconds:.1f} s")
    return table
