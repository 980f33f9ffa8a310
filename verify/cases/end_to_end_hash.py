"""Runs the C++ programs that print what happened as a hash: verify_end_to_end_hash, verify_episodes and others."""

import os
import subprocess
from pathlib import Path
from typing import Any

from verify.cases import aarch64
from verify.cases.trees import PROGRAMS


def hashes(command: list[str | Path], **environment: str) -> dict[str, str]:
    """What was run, and its hash."""
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, **environment})
    if done.returncode != 0:
        raise RuntimeError(f"{command} ended with {done.returncode}: {done.stderr}")
    return dict(line.rsplit(" ", 1) for line in done.stdout.splitlines())


def truth_isolation(seed: int) -> dict[str, Any]:
    """Drives in a world that states the truth about robots, and in one that falsifies it, by ours and peeking ones."""
    found = hashes([PROGRAMS / "verify_end_to_end_hash", str(seed), "--false-truth"])
    peeking = [run for run in found if run.startswith("truth, peeking at ")]
    return {
        "equal": found["truth"] == found["false truth"],
        "found_out": bool(peeking) and all(found[run] != found[f"false {run}"] for run in peeking),
    }


def instruct_in_false_truth(seed: int) -> dict[str, Any]:
    """An instruction where the truth is stated and where it is falsified: by our agent and by one that peeks."""
    found = hashes([PROGRAMS / "verify_agent", str(seed), "--false-truth"])
    peeking = "truth, peeking at things"
    return {
        "equal": found["truth"] == found["false truth"],
        "found_out": found[peeking] != found[f"false {peeking}"],
    }


def targets(seed: int, program: str) -> dict[str, Any]:
    """A program on every vector target of this machine."""
    found = hashes([PROGRAMS / program, str(seed)])
    return {"equal": len(set(found.values())) == 1, "targets": sorted({run.split()[0] for run in found})}


def processors(seed: int, program: str) -> dict[str, Any]:
    """A program on this processor and on an emulated 64-bit Arm one."""
    if missing := aarch64.missing():
        return {"not_shown": missing}
    here = hashes([PROGRAMS / program, str(seed)])
    there = hashes([aarch64.EMULATOR, aarch64.program(program), str(seed)], **aarch64.ENVIRONMENT)
    return {"equal": len({*here.values(), *there.values()}) == 1, "targets": sorted({run.split()[0] for run in there})}
