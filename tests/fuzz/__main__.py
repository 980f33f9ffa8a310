"""python -m tests.fuzz [format ...] [--runs N | --seconds S] [--jobs N]: fuzzes what `./dev fuzz` has built."""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import time
from pathlib import Path

from tests.fuzz import python_fuzzer

ROOT = Path(__file__).resolve().parent.parent.parent
BUILD = ROOT / "build" / "fuzz"
KEPT = BUILD / "corpus"
"""Inputs that reached code which none before had reached, a folder for each format: the next run begins with them."""
CORPUS = Path(__file__).parent / "corpus"
"""The first inputs of each format."""

NATIVE = tuple(sorted(path.name.removesuffix("_fuzzer.cpp") for path in Path(__file__).parent.glob("*_fuzzer.cpp")))
"""Formats that are read in C++: <format>_fuzzer.cpp."""

FORMATS = (*NATIVE, *python_fuzzer.FORMATS)
WALL_LIMIT = 120  # [s] for one input, which others may keep waiting; how long it may compute says fuzz.hpp
MEMORY_LIMIT = 3072  # [MB] of a process; how much an input may take says fuzz.hpp
LONGEST = 16384  # [bytes] of an input ...
LONGEST_LEXICON = 65536  # ... and of that whose smallest seed is larger


def fuzz(name: str, runs: int, seconds: float, seed: int = 0) -> tuple[int, str]:
    """How many inputs a format's reader has read, and what it did wrong with the last; nothing if it did not.

    It reads seeds and kept inputs first, then `runs` changed ones.
    """
    artifacts = BUILD / "artifacts"
    for folder in (KEPT / name, artifacts):
        folder.mkdir(parents=True, exist_ok=True)
    if name in python_fuzzer.FORMATS:
        return python_fuzzer.fuzz(name, runs, seconds, seed, KEPT / name)
    runs += sum(path.is_file() for folder in (KEPT, CORPUS) for path in (folder / name).rglob("*"))
    command = [
        BUILD / "tests" / "fuzz" / f"{name}_fuzzer",
        KEPT / name,
        CORPUS / name,
        f"-runs={runs}",
        f"-max_total_time={min(int(seconds), 10**9)}",
        f"-seed={seed}",
        f"-timeout={WALL_LIMIT}",
        f"-rss_limit_mb={MEMORY_LIMIT}",
        f"-max_len={LONGEST_LEXICON if name == 'lexicon' else LONGEST}",
        f"-artifact_prefix={artifacts}/{name}-",
        "-print_final_stats=1",
        "-verbosity=1",
    ]
    environment = {
        **os.environ,
        "THREEWE_ASSETS": str(ROOT / "assets"),
        "ASAN_OPTIONS": "detect_leaks=0:allocator_may_return_null=1",  # a length that was forged: std::bad_alloc
        "UBSAN_OPTIONS": "halt_on_error=1:print_stacktrace=1",
    }
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, errors="replace", env=environment)
    executed = re.search(r"stat::number_of_executed_units: (\d+)", done.stderr)
    if done.returncode == 0:
        return int(executed.group(1)) if executed else 0, ""
    errors = [
        line for line in done.stderr.splitlines() if re.search(r"ERROR|fuzz:|runtime error|Test unit written", line)
    ]
    return int(executed.group(1)) if executed else 0, " | ".join(errors)[:600] or done.stderr[-600:]


def kept_inputs(name: str) -> set[Path]:
    """The inputs of a format that are kept now."""
    return set((KEPT / name).glob("*"))


def main() -> int:
    """Prints a line per format; 1 if one failed."""
    parser = argparse.ArgumentParser(prog="./dev fuzz", description="Reads changed inputs of formats.")
    parser.add_argument("formats", nargs="*", metavar="format", help=", ".join(FORMATS))
    parser.add_argument("--runs", type=int, default=2000, help="changed inputs of each format")
    parser.add_argument("--seconds", type=float, default=1e9, help="and no longer than so")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    if unknown := set(options.formats) - set(FORMATS):
        parser.error(f"no format {', '.join(unknown)}; there are {', '.join(FORMATS)}")
    failed = False
    for name in options.formats or FORMATS:
        begin, before = time.monotonic(), kept_inputs(name)
        count, failure = fuzz(name, options.runs, options.seconds, options.seed)
        failed = failed or bool(failure)
        new, seconds = len(kept_inputs(name) - before), time.monotonic() - begin
        print(f"{name:15}{count:10} inputs {new:6} new kept {seconds:7.0f} s  {failure or 'ok'}", flush=True)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
