"""Makes a wheel, and runs it in a root folder that has a Python and nothing else."""

import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from python.make_wheel import OWN_VERSION, VERSIONS, build, interpreters, repair
from verify.cases.bare_root import BareRoot, missing
from verify.cases.trees import ROOT
from verify.harness import Case, Experiment, all_of

FIVE_LINES = re.findall(r"^```python\n(.*?)^```", (ROOT / "README.md").read_text(), re.M | re.S)[0]
PASTE = """
import ast, asyncio, sys
code = compile(sys.argv[1], "README.md", "exec", flags=ast.PyCF_ALLOW_TOP_LEVEL_AWAIT)
asyncio.run(eval(code, {}))
"""
COMPLETE = [
    "_core.pyi",
    "py.typed",
    "commit.txt",
    "assets/scenes/office_v2.yaml",
    "assets/objects/chair.yaml",
    "assets/localization/slam_v2.yaml",
]


def plain(_seed: int, version: str) -> Case:
    """The package without extras. Before its repair, the wheel must fail: or else that root hides nothing."""
    python = Path(sys.executable) if version == OWN_VERSION else interpreters()[version]
    if lacking := missing() or (python is None and f"Python {version} is not installed"):
        return {"not_shown": lacking}
    linked = build(version, python)
    wheel = repair(linked)
    with installed(python, f"{wheel}") as root:
        package = root.venv / f"lib/python{version}/site-packages/threewe"
        case = {
            "absent": [file for file in COMPLETE if not (package / file).exists()],
            "five_lines": root.run("-c", PASTE, FIVE_LINES),
            "scenes": root.run(root.venv / "bin/threewe", "scenes", "list"),
            "doctor": root.run(root.venv / "bin/threewe", "doctor"),
        }
    with installed(python, f"{linked}") as root:
        return {"wheel": wheel.name, **case, "unrepaired": root.run("-c", "import threewe")}


def demo(_seed: int) -> Case:
    """The whole demo, from the package with its extra."""
    if lacking := missing():
        return {"not_shown": lacking}
    wheel = repair(build(OWN_VERSION, Path(sys.executable)))
    with installed(Path(sys.executable), f"{wheel}[demo]") as root:
        return {"demo": root.run(root.venv / "bin/threewe", "demo", "-o", "/tmp/demo")}


def transfer(_seed: int) -> Case:
    """A small run of the transfer protocol, from the package with its extra."""
    if lacking := missing():
        return {"not_shown": lacking}
    wheel = repair(build(OWN_VERSION, Path(sys.executable)))
    protocol = ["--scene", "apartment_v1", "--episodes", "2", "--seeds", "2", "--target-episodes", "1"]
    command = ["transfer", "run", "--policy", "navigator", "--source", "mock", "--target", "mujoco", *protocol]
    with installed(Path(sys.executable), f"{wheel}[mujoco]") as root:
        return {"transfer": root.run(root.venv / "bin/threewe", *command, "-o", "/tmp/transfer.json")}


@contextmanager
def installed(python: Path, requirement: str) -> Iterator[BareRoot]:
    """An empty environment into which pip has installed a wheel and what it asks for, in an empty root."""
    with tempfile.TemporaryDirectory() as folder:
        venv = Path(folder) / "venv"
        subprocess.run([python, "-m", "venv", "--copies", venv], check=True)
        pip = [venv / "bin/python", "-m", "pip", "install", "-q", "--disable-pip-version-check"]
        subprocess.run([*pip, requirement], check=True)
        yield BareRoot(Path(folder) / "root", venv)


EXPERIMENTS = [
    *(
        Experiment(
            f"Python {version} in an empty root",
            plain,
            {"version": version},
            rows=[
                all_of("the wheel is complete", lambda case: not case["absent"]),
                all_of(
                    "the five lines of the README arrive", lambda case: "Success: True" in case["five_lines"]["out"]
                ),
                all_of("threewe scenes lists them", lambda case: "office_v2" in case["scenes"]["out"]),
                all_of("threewe doctor finds nothing broken", lambda case: case["doctor"]["status"] == 0),
                all_of("unrepaired it lacks libraries", lambda case: "cannot open shared" in case["unrepaired"]["out"]),
            ],
        )
        for version in VERSIONS
    ),
    Experiment(
        f"Python {OWN_VERSION} in an empty root, with the demo",
        demo,
        rows=[all_of("threewe demo arrives", lambda case: case["demo"]["status"] == 0)],
    ),
    Experiment(
        f"Python {OWN_VERSION} in an empty root, with MuJoCo",
        transfer,
        rows=[
            all_of(
                "threewe transfer compares both simulators",
                lambda case: case["transfer"]["status"] == 0 and "SR target / SR source: " in case["transfer"]["out"],
            )
        ],
    ),
]
