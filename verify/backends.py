"""MuJoCo's sensors see what the embedded simulator's do; a backend that keeps the contract passes every check of it.

Scenes, robots and seeds vary; what a body that tilts changes is measured too.
"""

import importlib.util
import json
import random
import subprocess
import sys
from pathlib import Path

import threewe
from threewe.testing import check_backend

from verify.camera import SCENES, share_off
from verify.cases.trees import PROGRAMS, ROOT
from verify.harness import Case, Experiment, Row, all_of, each, worst_of

PROGRAM = PROGRAMS / "verify_backends"
POSES = 20
"""Of each case: making a world takes longer than a pose."""


def library() -> Path | None:
    """MuJoCo's, where its package is installed."""
    package = importlib.util.find_spec("mujoco")
    if package is None or package.origin is None:
        return None
    return next(Path(package.origin).parent.glob("libmujoco.so.*"), None)


def look(seed: int, scene: str) -> Case:
    """Beams and pixels from some poses, and how many are off: from the very same place, as the robot stands on its
    wheels, and as it drives.
    """
    path = library()
    if path is None:
        return {"not_shown": "mujoco-core is not installed"}
    command = [PROGRAM, path, scene, str(seed), str(POSES)]
    output = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return {name: json.loads(value) for name, value in (line.split() for line in output.splitlines())}


def toy_backend() -> None:
    """Registers the backend of examples/06_toy_backend.py."""
    spec = importlib.util.spec_from_file_location("toy", ROOT / "examples/06_toy_backend.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["toy"] = module
    spec.loader.exec_module(module)
    threewe.register_backend("toy", module.ToyBackend)


def keep_the_contract(seed: int, backend: str, robots: list[str]) -> Case:
    """The checks that an honest backend fails, with a robot, a scene and noise drawn by the seed."""
    if backend == "mujoco" and library() is None:
        return {"not_shown": "mujoco-core is not installed"}
    if backend == "toy":
        toy_backend()
    draw = random.Random(seed)
    drawn = {
        "hardware": draw.choice(robots),
        "scene": draw.choice(SCENES),
        "noise": draw.choice(["realistic", "ideal"]),
    }
    results = check_backend(backend, seed=seed, show=False, **drawn)
    return {**drawn, "failed": [f"{result.name}: {result.detail}" for result in results if not result.passed]}


def geometry() -> list[Row]:
    """What sensors may be off: from the very same place, as the robot stands on its wheels, and as it drives."""
    return [
        share_off("same pose: beams more than 1 cm off", "exact_beams_off", "exact_beams", at_most=0.001),
        share_off("same pose: depths off by 2 cm and 1 %", "exact_depth_off", "exact_compared", at_most=0.01),
        share_off("same pose: another id", "exact_ids_off", "exact_compared", at_most=0.01),
        share_off("same pose: pixels next to an edge, left out", "exact_edges", "exact_pixels", at_most=0.05),
        *(row for how, deepest in (("settled", 0.2), ("driving", 5.0)) for row in in_motion(how, deepest)),
    ]


def in_motion(how: str, deepest: float) -> list[Row]:
    """What is asked of a robot on its wheels, which may sink so deep [mm]."""
    return [
        share_off(f"{how}: beams more than 1 cm off", f"{how}_beams_off", f"{how}_beams", at_most=0.01),
        share_off(f"{how}: depths off by 2 cm and 1 %", f"{how}_depth_off", f"{how}_compared", at_most=0.1),
        worst_of(f"{how}: tilt [mrad]", lambda case: case[f"{how}_tilt_mrad"], at_most=20.0),
        worst_of(f"{how}: off the floor [mm]", lambda case: case[f"{how}_sunk_mm"], at_most=deepest),
    ]


HONEST = {
    "mock": ["3we_standard_v2", "3we_base_v2", "3we_depth_v2", "turtlebot_like"],
    "toy": ["3we_standard_v2", "turtlebot_like"],
    "mujoco": ["3we_standard_v2", "3we_depth_v2", "turtlebot_like"],
}
NO_CHECK_FAILS = all_of("no check fails", lambda case: not case["failed"])

EXPERIMENTS = [
    Experiment(
        "check_backend of backends that keep the contract",
        keep_the_contract,
        variants=[{"backend": backend, "robots": robots} for backend, robots in HONEST.items()],
        cases=150,
        rows=[NO_CHECK_FAILS, *each("backend", HONEST, lambda _: NO_CHECK_FAILS)],
    ),
    Experiment(
        "MuJoCo's sensors next to ours, 3we_depth_v2",
        look,
        variants=[{"scene": scene} for scene in SCENES],
        cases=350,
        rows=[*geometry(), *(row for claim in geometry() for row in each("scene", SCENES, lambda _, row=claim: row))],
    ),
]
