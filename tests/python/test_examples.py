"""Every Python example runs, in its quick form. (ctest runs the C++ ones.)"""

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
NEEDS = {
    "09_ppo.py": ["torch", "safetensors"],
    "10_sb3.py": ["stable_baselines3"],
}  # extra "train"
ELSEWHERE = {"12_end_to_end.py"}  # benchmark/test_mlp.py runs it, and drives the policy that it saves

BY_NIGHT = {"10_sb3.py"}  # by day 12_end_to_end.py learns with the same library


def by_night(name: str) -> object:
    return pytest.param(name, marks=pytest.mark.nightly) if name in BY_NIGHT else name


@pytest.mark.parametrize(
    "name", [by_night(path.name) for path in sorted(EXAMPLES.glob("*.py")) if path.name not in ELSEWHERE]
)
def test_example(name: str, tmp_path: Path) -> None:
    for package in NEEDS.get(name, []):
        pytest.importorskip(package, reason=f"not shown: {package} is not installed")
    subprocess.run([sys.executable, "-W", "error", EXAMPLES / name, "--quick"], cwd=tmp_path, check=True)
