"""Our localisation in maps that a robot drew before: does it find itself, and notice when it is carried away?"""

import subprocess
import tempfile
from pathlib import Path
from typing import Any

from verify.cases.localization import SCENES
from verify.cases.trees import PROGRAMS
from verify.harness import Case, Row, Verdict

PROGRAM = PROGRAMS / "verify_localization"
PLACES = 5  # in each map
QUICK = 10.0  # [s] to be back after having been carried away


def placements(seed: int, mind: str = "map") -> Case:
    """A map of every scene, drawn by a robot that explores it, and robots that are put somewhere into it. `mind` is
    `truth` where the robot that draws is told where it is, so that the map's own errors are none.
    """
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for scene in SCENES:
            file = Path(folder) / f"{scene}.yaml"
            tell(mind, scene, seed, file)
            found += [placement(scene, seed + i, file) for i in range(PLACES)]
    return {"placements": [each for each in found if each]}


def placement(scene: str, seed: int, file: Path) -> dict[str, Any]:
    """One robot: found, driven, carried away, found again. Empty where the map holds too little to be put into."""
    told = dict(line.split(" ", 1) for line in tell("find", scene, seed, file).splitlines())
    if "recovered" not in told:
        return {}
    squares, count = told["nees"].split()
    numbers = {name: float(told[name]) for name in ("found", "wrong", "knew", "noticed", "recovered", "wrong_after")}
    return {"scene": scene, "seed": seed, **numbers, "nees": float(squares), "counted": int(count)}


def tell(what: str, scene: str, seed: int, file: Path) -> str:
    """What the program says."""
    command = [PROGRAM, what, scene, str(seed), file]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def of_placements(row: Row) -> Row:
    """The row, about placements instead of cases."""

    def judge(cases: list[Case], sample: bool) -> Verdict:
        return row.judge([each for case in cases for each in case.get("placements", [case])], sample)

    return Row(row.name, judge)


def of_those_carried(row: Row) -> Row:
    """The row, about placements in which the robot knew where it was before it was carried away."""

    def judge(cases: list[Case], sample: bool) -> Verdict:
        return row.judge([case for case in cases if case.get("knew", 1.0)], sample)

    return of_placements(Row(row.name, judge))


def finds_itself(case: Case) -> bool:
    """While it stands, within 10 s."""
    return bool(case["found"] >= 0.0)


def claims_the_truth(case: Case) -> bool:
    """Never, while it is not lost, more than 0.3 m off; but for the time until it notices that it was carried away."""
    return bool(case["wrong"] == case["wrong_after"] == 0.0)


def is_back(case: Case) -> bool:
    """It knows where it is soon after it was carried away."""
    return bool(0.0 <= case["recovered"] <= QUICK)


def time_to_be_back(case: Case) -> float:
    """[s], of those that are."""
    return float(case["recovered"] if case["recovered"] >= 0.0 else QUICK)


def notices(case: Case) -> bool:
    """It says soon that it is lost, or is right."""
    return bool(0.0 <= case["noticed"] <= 5.0)


def honest(name: str, low: float, high: float) -> Row:
    """The mean normalised squared error of poses, 3 where covariances are honest."""

    def judge(cases: list[Case], sample: bool) -> Verdict:
        del sample
        target = f"{low:g} to {high:g}"
        counted = sum(case["counted"] for case in cases if "error" not in case)
        if counted == 0 or any("error" in case for case in cases):
            return Verdict("cases broke", target, "FAIL")
        mean = sum(case["nees"] for case in cases) / counted
        return Verdict(f"mean {mean:.2f} of {counted}", target, "pass" if low <= mean <= high else "FAIL")

    return of_placements(Row(name, judge))
