"""MuJoCo's sensors see what the embedded simulator's do, in every scene; and what a body that tilts changes."""

import importlib.util
import json
import subprocess
from pathlib import Path

from verify.camera import SCENES, share_off
from verify.cases.trees import PROGRAMS
from verify.harness import Case, Experiment, worst_of

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


EXPERIMENTS = [
    Experiment(
        f"3we_depth_v2 in {scene}",
        look,
        {"scene": scene},
        cases=50,
        sample=1,
        rows=[
            share_off("same pose: beams more than 1 cm off", "exact_beams_off", "exact_beams", at_most=0.001),
            share_off("same pose: depths off by 2 cm and 1 %", "exact_depth_off", "exact_compared", at_most=0.01),
            share_off("same pose: another id", "exact_ids_off", "exact_compared", at_most=0.01),
            share_off("same pose: pixels beside an edge, left out", "exact_edges", "exact_pixels", at_most=0.05),
            *(
                row
                for how, deepest in (("settled", 0.2), ("driving", 5.0))
                for row in (
                    share_off(f"{how}: beams more than 1 cm off", f"{how}_beams_off", f"{how}_beams", at_most=0.01),
                    share_off(f"{how}: depths off by 2 cm and 1 %", f"{how}_depth_off", f"{how}_compared", at_most=0.1),
                    worst_of(f"{how}: tilt [mrad]", lambda case, how=how: case[f"{how}_tilt_mrad"], at_most=20.0),
                    worst_of(
                        f"{how}: off the floor [mm]", lambda case, how=how: case[f"{how}_sunk_mm"], at_most=deepest
                    ),
                )
            ),
        ],
    )
    for scene in SCENES
]
