"""What becomes of a drive when one parameter of the autonomy stack is half or twice as large."""

import asyncio
import math
import os
import random
import tempfile
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import yaml
from threewe import AutonomyParameter, Pose2D, Robot, RobotProfile, Scene, SceneTables
from threewe.benchmark import spl

from verify.cases import labyrinths
from verify.cases.driving import explore_from
from verify.cases.generated import PLACES, building, drive_to, far_goal, saved
from verify.cases.trees import ROOT

HARDWARE = "3we_standard_v2"
FACTORS = (0.5, 2.0)
Drive = Callable[[str, str, int, Pose2D, tuple[float, float], float], Coroutine[Any, Any, dict[str, Any]]]
PAGE = ROOT / "docs/parameters.md"
HEAD = """\
# Parameters of the autonomy stack

Every tuned number of the autonomy stack is a parameter of the robot: its default is that of `3we_standard_v2`, it grows
from robot to robot with its *scale*, and the `autonomy:` section of a [profile](how-to-drive.md#parameters) sets it.
`threewe hardware show NAME --parameters` prints those of a robot.

*Half* and *twice*: by how much success and success weighted by path length (SPL) change, the means of {cases}
generated buildings (`./dev verify sensitivity --write-model`, commit {commit}, seed {seed}). Each parameter is tried
where it counts: on a far drive; through seven narrow doors (`nav.creep`, `nav.bottleneck`, `nav.recovery`, `nav.arcs`,
`nav.narrow_passage`, `safety.creep`); as the robot explores, where success is a coverage of 0.95, and SPL the coverage
times how much sooner or later it ends (`nav.frontier`); put elsewhere without a word after a first drive
(`slam.localization`, `slam.global_search`); among people (`health.people`, `safety.approach`); in a large bare room
(`nav.route.sight`, `nav.route.blind_weight`). `=`: every drive is the same to the bit, as where a parameter is of what
does not happen: no sensor fails. `-`: a count that cannot be halved.
"""


def sensitivity(seed: int) -> dict[str, Any]:
    """What becomes of each parameter's drive in places of this seed: as ever, and then with the parameter changed."""
    usual = {place: place(seed, HARDWARE) for place in (far, *TRIED_ELSEWHERE)}
    answers = {}
    for parameter in RobotProfile.load(HARDWARE).parameters():
        place = next((place for place, names in TRIED_ELSEWHERE.items() if parameter.name.startswith(names)), far)
        for factor in FACTORS:
            with overridden(parameter, factor) as hardware:
                changed = place(seed, hardware) if hardware else None
            answers[f"{parameter.name} {factor:g}"] = changed and {
                "success": succeeds(changed) - succeeds(usual[place]),
                "spl": path_weighted(changed, usual[place]) - path_weighted(usual[place], usual[place]),
                "same": changed == usual[place],
                "untrue": changed["reason"] == "reached" and changed.get("true_distance", 0.0) > 0.25,
            }
    return {"answers": answers, "spl": usual[far]["spl"]}


def succeeds(case: dict[str, Any]) -> bool:
    """It is where it should be, or has seen what it should."""
    return bool(case["coverage"] >= 0.95 if "coverage" in case else case["spl"] > 0.0)


def path_weighted(case: dict[str, Any], usual: dict[str, Any]) -> float:
    """SPL; of an exploration, the coverage times how much sooner it ends than as ever."""
    if "coverage" not in case:
        return float(case["spl"])
    return float(case["coverage"] * usual["seconds"] / case["seconds"])


def far(seed: int, hardware: str, place: str = "building", drive: Drive = drive_to) -> dict[str, Any]:
    """A far drive in a generated building."""
    with saved(PLACES[place](seed)) as scene:
        tables = SceneTables(Scene.load(scene), RobotProfile.load(HARDWARE))
        start, goal, geodesic = far_goal(Scene.load(scene), tables, seed)
        return asyncio.run(drive(scene, hardware, seed, start, goal, geodesic))


def peopled(seed: int, hardware: str) -> dict[str, Any]:
    """A far drive among people."""
    return far(seed, hardware, "peopled")


def bare(seed: int, hardware: str) -> dict[str, Any]:
    """A far drive in a large bare room."""
    return far(seed, hardware, "hall")


def kidnapped(seed: int, hardware: str) -> dict[str, Any]:
    """A far drive once more, by a robot that was put back to its start, and turned, without a word."""
    return far(seed, hardware, drive=drive_twice)


async def drive_twice(
    scene: str, hardware: str, seed: int, start: Pose2D, goal: tuple[float, float], geodesic: float
) -> dict[str, Any]:
    to = start.inverse() * Pose2D(*goal, 0.0)
    async with Robot(scene=scene, hardware=hardware, seed=seed, start_pose=start) as robot:
        truth = robot.simulation
        assert truth is not None
        await robot.move_to(to.x, to.y)
        truth.teleport(start * Pose2D(0.0, 0.0, 2.0))
        await robot.sleep(4.0)  # until it has noticed
        before = truth.distance_driven()
        result = await robot.move_to(to.x, to.y)
        pose = truth.true_pose()
        distance = math.hypot(pose.x - goal[0], pose.y - goal[1])
        arrived = result.reason == "reached" and distance <= 0.25
        return {
            "reason": result.reason.name,
            "seconds": result.duration,
            "true_distance": distance,
            "spl": spl(arrived, geodesic, truth.distance_driven() - before),
        }


def exploration(seed: int, hardware: str) -> dict[str, Any]:
    """A building explored from a free place."""
    with saved(building(seed)) as scene:
        tables = SceneTables(Scene.load(scene), RobotProfile.load(HARDWARE))
        return explore_from(tables.sample_free_pose(seed), seed, scene, hardware=hardware)


def narrow(seed: int, hardware: str) -> dict[str, Any]:
    """A drive through a corridor with narrow doors."""
    made = labyrinths.PLACES["doors"](random.Random(seed), labyrinths.width_of(RobotProfile.load(HARDWARE).footprint))
    with saved(made.text(f"doors_{seed}")) as scene:
        return asyncio.run(drive_to(scene, hardware, seed, Pose2D(), made.goal, made.goal[0]))


# where a parameter counts, if not on a far drive
TRIED_ELSEWHERE = {
    narrow: ("nav.narrow_passage", "nav.bottleneck", "nav.creep", "nav.arcs", "nav.recovery", "safety.creep"),
    exploration: ("nav.frontier",),
    kidnapped: ("slam.localization", "slam.global_search"),
    peopled: ("health.people", "safety.approach"),
    bare: ("nav.route.sight", "nav.route.blind_weight"),
}


@contextmanager
def overridden(parameter: AutonomyParameter, factor: float) -> Iterator[str | None]:
    """A profile with one parameter changed; none where a count cannot be halved."""
    value = factor * parameter.value
    if parameter.is_count:
        value = float(round(value + 0.01))
    if value == parameter.value or value == 0.0:
        yield None
        return
    profile = yaml.safe_load((ROOT / "assets/robots" / f"{HARDWARE}.yaml").read_text())
    node: Any = int(value) if parameter.is_count else value
    for part in reversed(parameter.name.split(".")):
        node = {part: node}
    profile["autonomy"] = node
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{HARDWARE}.yaml"
        path.write_text(yaml.safe_dump(profile))
        yield os.fspath(path)


def write_page(cases: list[dict[str, Any]], commit: str, seed: int) -> None:
    """The table of all parameters: docs/parameters.md."""
    lines = [HEAD.format(cases=len(cases), seed=seed, commit=commit)]
    module = ""
    for parameter in RobotProfile.load(HARDWARE).parameters():
        if parameter.name.split(".")[0] != module:
            module = parameter.name.split(".")[0]
            lines += [
                f"## {module}",
                "",
                "| parameter | default | scale | half: success / SPL | twice: success / SPL | meaning |",
                "|---|---|---|---|---|---|",
            ]
        value = f"{parameter.value:.4g} {parameter.unit}".strip()
        half, twice = (answer(cases, f"{parameter.name} {factor:g}") for factor in FACTORS)
        lines.append(f"| `{parameter.name}` | {value} | {parameter.scale} | {half} | {twice} | {parameter.meaning} |")
    PAGE.write_text("\n".join([*lines, ""]))


def answer(cases: list[dict[str, Any]], change: str) -> str:
    """The mean changes of success and SPL, over all cases."""
    answers = [case["answers"][change] for case in cases]
    if None in answers:
        return "-"
    if all(one["same"] for one in answers):
        return "="
    return " / ".join(f"{sum(one[name] for one in answers) / len(answers):+.2f}" for name in ("success", "spl"))
