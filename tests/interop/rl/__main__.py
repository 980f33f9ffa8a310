"""Trains with every library on every task, each in a process of its own, and prints a row for each.

Then it runs the tests of our own faces to these libraries.

python -m tests.interop.rl                        # all of them
python -m tests.interop.rl cleanrl Navigation     # one of them, in this process
"""

import importlib
import os
import subprocess
import sys
import time

import threewe  # noqa: F401 (registers the environments)

LIBRARIES = ("sb3", "sb3_tools", "cleanrl", "rllib", "torchrl")
TASKS = ("Navigation", "Exploration", "ObjectNav", "VLN")
STEPS = 2_000
TESTS = ("tests/python/test_gym_sb3.py", "tests/python/test_gym_torch.py")  # which need what is installed here
ENVIRONMENT = {"OMP_NUM_THREADS": "1", "CUDA_VISIBLE_DEVICES": "", "RAY_USAGE_STATS_ENABLED": "0"}


def main(arguments: list[str]) -> int:
    if len(arguments) == 2:
        library, task = arguments
        print(importlib.import_module(f"tests.interop.rl.{library}").train(f"3we/{task}-v1", STEPS))
        return 0
    pairs = [(library, task) for library in LIBRARIES for task in TASKS]
    failed = [f"{library} {task}" for library, task in pairs if not works(library, task)]
    print(f"{len(pairs) - len(failed)} of {len(pairs)} work", *failed, sep="\n", flush=True)
    tests = subprocess.run([sys.executable, "-m", "pytest", "-q", *TESTS], env={**os.environ, **ENVIRONMENT})
    return int(bool(failed) or tests.returncode != 0)


def works(library: str, task: str) -> bool:
    """Whether it trains and gives no warning, in a row of the table; what a failed one said follows."""
    began = time.monotonic()
    words = [sys.executable, "-m", "tests.interop.rl", library, task]
    done = subprocess.run(words, env={**os.environ, **ENVIRONMENT}, capture_output=True, text=True)
    ok = done.returncode == 0
    told = done.stdout.strip().splitlines()[-1] if ok else "FAILED"
    print(f"{library:10} {task:12} {time.monotonic() - began:5.0f} s  {told}", flush=True)
    if not ok:
        print(done.stdout[-1000:], done.stderr[-3000:], sep="\n", flush=True)
    return ok


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
