"""The controller alone, through doors, round boxes and people: do fewer samples cost anything?"""

import subprocess

from verify.cases.trees import PROGRAMS
from verify.harness import Case, Experiment, Row, Verdict, wilson

FEW, MANY = 2000, 8000


def drive_courses(seed: int) -> Case:
    """How many of the courses of one seed are driven, touching nothing, with few samples and with many."""
    command = [PROGRAMS / "verify_control", str(seed), str(FEW), str(MANY)]
    lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    few, many = ([int(word) for word in line.split()] for line in lines)
    return {"few": few[1], "many": many[1], "courses": few[2]}


def no_lower() -> Row:
    """Whether few samples do as well as many, within the interval of either."""

    def judge(cases: list[Case], _: bool) -> Verdict:
        if any("error" in case for case in cases):
            return Verdict("cases broke", "", "FAIL")
        few, many, courses = (sum(case[key] for case in cases) for key in ("few", "many", "courses"))
        _, high = wilson(few, courses)
        figure = f"{few}/{courses} = {few / courses:.1%}, {many}/{courses} = {many / courses:.1%}"
        status = "pass" if high >= many / courses else "FAIL"
        return Verdict(figure, "no lower, within its interval", status, f"[.., {high:.1%}]")

    return Row(f"driven with {FEW:,} and with {MANY:,} samples", judge)


EXPERIMENTS = [Experiment("courses", drive_courses, cases=40, rows=[no_lower()])]
