"""Every Python example runs, in its quick form. (ctest runs the C++ ones.)"""

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
NEEDS = {
    "09_ppo.py": ["torch", "safetensors"],
    "10_sb3.py": ["stable_baselines3"],
    "12_end_to_end.py": ["stable_baselines3"],
}  # extra "train"


@pytest.mark.parametrize("name", sorted(path.name for path in EXAMPLES.glob("*.py")))
def test_example(name: str, tmp_path: Path) -> None:
    for package in NEEDS.get(name, []):
        pytest.importorskip(package, reason=f"not shown: {package} is not installed")
    subprocess.run([sys.executable, "-W", "error", EXAMPLES / name, "--quick"], cwd=tmp_path, check=True)
