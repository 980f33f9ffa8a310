"""Our localisation in maps that a robot drew before: does it find itself, and notice when it is carried away?"""

import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from verify.cases.trees import PROGRAMS
from verify.harness import Case, Row, ratio_of, share_within, within

PROGRAM = PROGRAMS / "verify_localization"
PLACES = 5  # in each map
QUICK = 10.0  # [s] to be back after having been carried away


def placements(seed: int, scene: str, mind: str = "map") -> Case:
    """A map of a scene, drawn by a robot that explores it, and robots that are put somewhere into it. `mind` is `truth`
    where the robot that draws is told where it is, so that the map's own errors are none.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "map.yaml"
        run(mind, scene, seed, file)
        found = [placement(scene, seed + i, file) for i in range(PLACES)]
    return {"placements": [each for each in found if each]}


def placement(scene: str, seed: int, file: Path) -> dict[str, Any]:
    """One robot: found, driven, carried away, found again. Empty where the map holds too little to be put into."""
    printed = dict(line.split(" ", 1) for line in run("find", scene, seed, file).splitlines())
    if "recovered" not in printed:
        return {}
    squares, count = printed["nees"].split()
    numbers = {name: float(printed[name]) for name in ("found", "wrong", "knew", "noticed", "recovered", "wrong_after")}
    return {"scene": scene, "seed": seed, **numbers, "nees": float(squares), "counted": int(count)}


def run(what: str, scene: str, seed: int, file: Path) -> str:
    """What the program prints."""
    command = [PROGRAM, what, scene, str(seed), file]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def of_placements(name: str, holds: Callable[[Case], bool], enough: float) -> Row:
    """The share of placements in which something holds."""
    return share_within(name, lambda case: case["placements"], holds, at_least=enough)


def of_those_carried(name: str, holds: Callable[[Case], bool], enough: float) -> Row:
    """The same of placements in which the robot knew where it was before it was carried away."""
    return share_within(name, lambda case: [one for one in case["placements"] if one["knew"]], holds, at_least=enough)


def finds_itself(case: Case) -> bool:
    """While it stands, within 10 s."""
    return bool(case["found"] >= 0.0)


def claims_the_truth(case: Case) -> bool:
    """Never, while it is not lost, more than 0.3 m off; but for the time until it notices that it was carried away."""
    return bool(case["wrong"] == case["wrong_after"] == 0.0)


def is_relocalized(case: Case) -> bool:
    """It knows where it is soon after it was carried away."""
    return bool(0.0 <= case["recovered"] <= QUICK)


def time_to_be_back(case: Case) -> float:
    """[s], of those that are."""
    return float(case["recovered"] if case["recovered"] >= 0.0 else QUICK)


def notices(case: Case) -> bool:
    """It says soon that it is lost, or is right."""
    return bool(0.0 <= case["noticed"] <= 5.0)


def consistent(name: str, **target: float) -> Row:
    """The mean normalised squared error of poses, 3 where covariances are right."""
    row = ratio_of(name, lambda case: case["nees"], lambda case: case["counted"], **target)
    return within(row, lambda case: case["placements"])
