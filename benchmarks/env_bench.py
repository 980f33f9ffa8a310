"""Learning environments, steps a second on one core through the Python batch API, as a table.

A step is one action, one control period, one scan, reward, termination and autoreset, of 1,024 environments in
office_v2. Each row states ticks (of 20 ms) a step, noise, beams and gate. Random actions, held for ten steps.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from threewe.gym import VectorEnv

HERE = Path(__file__).resolve().parent
ENVS = 1024
REPEATS = 5


@dataclass(frozen=True)
class Row:
    """What is measured, and what is wanted of it [steps/s]."""

    beams: int
    ticks: int
    noise: str
    gate: str
    wanted: float | None = None


ROWS = [
    Row(64, 1, "ideal", "limits", 1.5e6),
    Row(64, 5, "ideal", "limits", 1.0e6),
    Row(64, 5, "ideal", "full", 1.0e6),
    Row(64, 5, "realistic", "limits", 0.5e6),
    Row(64, 5, "realistic", "full", 0.5e6),
    Row(360, 1, "ideal", "limits", 0.45e6),
    Row(360, 1, "realistic", "limits", 0.2e6),
    Row(360, 1, "realistic", "full", 0.2e6),
]


def main() -> int:
    """Prints the table; writes the raw figures where --out says."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cpu", type=int, help="the CPU to run on")
    parser.add_argument("--out", type=Path, help="a file for the raw figures")
    parser.add_argument("--seconds", type=float, default=2.0, help="of each measurement")
    arguments = parser.parse_args()
    if arguments.cpu is not None:
        os.sched_setaffinity(0, {arguments.cpu})
    print(f"{'beams':>5} {'ticks':>5} {'noise':>9} {'gate':>6} {'steps/s':>12} {'ns/step':>8} {'wanted':>10}")
    results = []
    for row in ROWS:
        rates = measure(row, arguments.seconds)
        rate = statistics.median(rates)
        wanted = f"{row.wanted:10,.0f} {rate / row.wanted:.2f} of it" if row.wanted else ""
        print(
            f"{row.beams:5} {row.ticks:5} {row.noise:>9} {row.gate:>6} {rate:12,.0f} {1e9 / rate:8.0f} {wanted}",
            flush=True,
        )
        results.append({**asdict(row), "steps_per_second": rates})
    if arguments.out:
        arguments.out.parent.mkdir(parents=True, exist_ok=True)
        arguments.out.write_text(json.dumps(results, indent=1))
    return 0


def measure(row: Row, seconds: float) -> list[float]:
    """Steps a second, several times over, after a warm-up."""
    options: dict[str, Any] = {
        "task": "navigation",
        "num_envs": ENVS,
        "observations": ("lidar", "goal"),
        "hardware": str(HERE / "robots" / f"bench_{row.beams}.yaml"),
        "noise": row.noise,
        "gate": row.gate,
        "control_rate": 50.0 / row.ticks,
        "max_steps": 500,
        "copy": False,
    }
    env = VectorEnv(**options)
    env.reset(seed=0)
    rng = np.random.default_rng(0)
    actions = [rng.uniform(-1, 1, (ENVS, 3)).astype(np.float32) for _ in range(20)]
    rates = []
    for repeat in range(REPEATS + 1):
        begin = time.perf_counter()
        steps = 0
        while time.perf_counter() - begin < seconds / (REPEATS + 1):
            env.step(actions[steps // 10 % len(actions)])
            steps += 1
        if repeat > 0:
            rates.append(steps * ENVS / (time.perf_counter() - begin))
    return rates


if __name__ == "__main__":
    raise SystemExit(main())
