"""Runs verify_people: a robot that drives among people, and how well it sees them."""

import json
import subprocess

from verify.cases.trees import PROGRAMS
from verify.harness import Case, Row, Verdict


def among_people(seed: int, seconds: int) -> Case:
    """What the program says."""
    command = [PROGRAMS / "verify_people", str(seed), str(seconds)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    case: Case = json.loads(done.stdout)
    return case


def ratio(name: str, part: str, whole: str, *, at_most: float) -> Row:
    """One sum over all cases as a share of another."""

    def judge(cases: list[Case], sample: bool) -> Verdict:
        most = 1.5 * at_most if sample else at_most  # one drive may meet the wrong people
        target = f"<= {most:.0%}"
        if any("error" in case for case in cases):
            return Verdict("cases broke", target, "FAIL")
        few, all_ = sum(case[part] for case in cases), sum(case[whole] for case in cases)
        status = "pass" if few <= most * all_ else "FAIL"
        return Verdict(f"{few}/{all_} = {few / max(all_, 1):.1%}", target, status)

    return Row(name, judge)
