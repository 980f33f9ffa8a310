"""Programs that wait for robot time in every way, equal to the tick on each Python."""

import subprocess
import sys
from pathlib import Path

from python.make_wheel import OWN_VERSION, VERSIONS, interpreters
from python.other_pythons import TESTS, environment
from verify.cases.trees import ROOT
from verify.harness import Case, Experiment, all_of


def transcripts(_seed: int, version: str) -> Case:
    """The pump's tests on one Python: what each program writes down must be what is kept in golden/."""
    python = Path(sys.executable)
    if version != OWN_VERSION:
        found = interpreters()[version]
        if found is None:
            return {"not_shown": f"Python {version} is not installed"}
        python = environment(version, found)
    tests = [str(path) for pattern in TESTS for path in sorted((ROOT / "tests/python").glob(pattern))]
    done = subprocess.run([python, "-m", "pytest", "-q", *tests], cwd=ROOT, capture_output=True, text=True)
    return {"equal": done.returncode == 0, "summary": done.stdout.splitlines()[-1]}


EXPERIMENTS = [
    Experiment(
        f"Python {version}",
        transcripts,
        {"version": version},
        rows=[all_of("every program's transcript is equal to the tick", lambda case: case["equal"])],
        alone=True,
    )
    for version in VERSIONS
]
