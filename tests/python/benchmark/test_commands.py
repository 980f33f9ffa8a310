"""Commands of `threewe benchmark`: frozen sets that are made and checked, bundles that are verified, and their progress."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from threewe.benchmark.attempt import Settings
from threewe.benchmark.bundle import write_bundle
from threewe.benchmark.episodes import digest, find_episodes
from threewe.benchmark.run import plan_run, results_of, run

from verify.cases.forgeries import Forger, other_commands, success_for_failure

THREEWE = str(Path(sys.executable).parent / "threewe")
SET = "vln_val_v1"  # that which is drawn in seconds


def command(folder: Path, *arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [THREEWE, "benchmark", *arguments], cwd=folder, capture_output=True, text=True, env=ENVIRONMENT | environment
    )
