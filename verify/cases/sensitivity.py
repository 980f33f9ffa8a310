"""What becomes of a drive when one parameter of the autonomy stack is half or twice as large."""

import asyncio
import os
import random
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import yaml
from threewe import AutonomyParameter, Pose2D, RobotProfile, Scene, SceneTables

from verify.cases.generated import building, drive_to, far_goal, saved
from verify.cases.labyrinths import PLACES, width_of
from verify.cases.trees import ROOT

HARDWARE = "3we_standard_v2"
FACTORS = (0.5, 2.0)
PAGE = ROOT / "docs/parameters.md"
HEAD = """\
# Parameters of the autonomy stack

Every tuned number of the autonomy stack is a parameter of the robot: its default is that of `3we_standard_v2`, it grows
from robot to robot with its *scale*, and the `autonomy:` section of a [profile](how-to-drive.md#parameters) sets it.
`threewe hardware show NAME --parameters` prints those of a robot.

*Half* and *twice*: by how much the mean success weighted by path length changes, over {cases} far drives in generated
buildings or, for parameters of tight places, through seven narrow doors (`./dev verify sensitivity --write-model`,
commit {commit}, seed {seed}). `=`: every drive is the same to the bit, as where a parameter is of what these drives do
not do: they explore nothing, meet no person and no fault, and know their pose. `-`: a count that cannot be halved.
"""


NARROW = ("nav.narrow_passage", "nav.bottleneck", "nav.creep", "nav.arcs", "nav.recovery", "safety.creep")


def sensitivity(seed: int) -> dict[str, Any]:
    """A far drive in one building, and one through narrow doors: as ever, and then with each parameter changed."""
    usual = {place: place(seed, HARDWARE) for place in (far, narrow)}
    answers = {}
    for parameter in RobotProfile.load(HARDWARE).parameters():
        place = narrow if parameter.name.startswith(NARROW) else far
        for factor in FACTORS:
            with overridden(parameter, factor) as hardware:
                changed = place(seed, hardware) if hardware else None
            answers[f"{parameter.name} {factor:g}"] = changed and {
                "spl": changed["spl"] - usual[place]["spl"],
                "same": changed == usual[place],
                "untrue": changed["reason"] == "reached" and changed["true_distance"] > 0.25,
            }
    return {"answers": answers, "spl": usual[far]["spl"]}


def far(seed: int, hardware: str) -> dict[str, Any]:
    """A far drive in a generated building."""
    with saved(building(seed)) as scene:
        tables = SceneTables(Scene.load(scene), RobotProfile.load(HARDWARE))
        start, goal, geodesic = far_goal(Scene.load(scene), tables, seed)
        return asyncio.run(drive_to(scene, hardware, seed, start, goal, geodesic))


def narrow(seed: int, hardware: str) -> dict[str, Any]:
    """A drive through a corridor with narrow doors."""
    made = PLACES["doors"](random.Random(seed), width_of(RobotProfile.load(HARDWARE).footprint))
    with saved(made.text(f"doors_{seed}")) as scene:
        return asyncio.run(drive_to(scene, hardware, seed, Pose2D(), made.goal, made.goal[0]))


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
                "| parameter | default | scale | half | twice | meaning |",
                "|---|---|---|---|---|---|",
            ]
        value = f"{parameter.value:.4g} {parameter.unit}".strip()
        half, twice = (answer(cases, f"{parameter.name} {factor:g}") for factor in FACTORS)
        lines.append(f"| `{parameter.name}` | {value} | {parameter.scale} | {half} | {twice} | {parameter.meaning} |")
    PAGE.write_text("\n".join([*lines, ""]))


def answer(cases: list[dict[str, Any]], name: str) -> str:
    """The mean change, over all cases."""
    answers = [case["answers"][name] for case in cases]
    if None in answers:
        return "-"
    if all(one["same"] for one in answers):
        return "="
    return f"{sum(one['spl'] for one in answers) / len(answers):+.3f}"
