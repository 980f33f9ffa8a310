"""Runs verify_journey, the C++ program that tells a journey as a hash."""

import os
import subprocess
from pathlib import Path
from typing import Any

from verify.cases import aarch64

PROGRAM = Path(__file__).resolve().parents[2] / "build/dev/verify/verify_journey"


def hashes(
    seed: int, *options: str, command: tuple[str | Path, ...] = (PROGRAM,), **environment: str
) -> dict[str, str]:
    """What was run, and its hash."""
    done = subprocess.run(
        [*command, str(seed), *options], capture_output=True, text=True, env={**os.environ, **environment}
    )
    if done.returncode != 0:
        raise RuntimeError(f"journey {seed} ended with {done.returncode}: {done.stderr}")
    return dict(line.rsplit(" ", 1) for line in done.stdout.splitlines())


def lies(seed: int) -> dict[str, Any]:
    """A journey in a world that tells the truth about the robot, and in one that lies."""
    found = hashes(seed, "--lie")
    return {"equal": len(found) == 2 and len(set(found.values())) == 1}


def targets(seed: int) -> dict[str, Any]:
    """A journey on every vector target of this machine, fresh and restored half-way."""
    found = hashes(seed)
    return {"equal": len(set(found.values())) == 1, "targets": sorted({run.split()[0] for run in found})}


def processors(seed: int) -> dict[str, Any]:
    """A journey on this processor and on an emulated 64-bit Arm one."""
    if missing := aarch64.missing():
        return {"not_shown": missing}
    here = hashes(seed)
    there = hashes(seed, command=(aarch64.EMULATOR, aarch64.program("verify_journey")), **aarch64.ENVIRONMENT)
    return {"equal": len({*here.values(), *there.values()}) == 1, "targets": sorted({run.split()[0] for run in there})}
