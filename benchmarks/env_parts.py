"""What one step of an environment is made of: instructions and cache misses by part, counted by callgrind; cycles
of the whole by the processor's own counters where perf can read them, and a guess by what callgrind counts.

Where there are so many environments that none stays in the modelled last cache from step to step, while a block of them
does within one, its misses of data tell how much memory a step touches.

Each function's own cost goes to the part that it belongs to by its name; that of a function that many share, such as
`sincos`, to the parts of its callers, in proportion to what their calls of it cost.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections import defaultdict
from dataclasses import asdict
from pathlib import Path

import numpy as np
from env_steps import Kind, actions_of
from numpy.typing import NDArray
from threewe.gym import VectorEnv

STEPS = 20  # that callgrind counts
STEPS_FOR_PERF = 500_000  # of all environments
EVENTS = ("cycles:u", "cache-misses:u")
NEAREST, LAST = 10, 100  # cycles that a miss is taken to cost, as KCachegrind does
PARTS = {  # by the first pattern that a function's name matches
    "lidar": r"RayCaster|sim::kernel::(N_\w+::)?(begin|point|intersect|finish|invert)|intersect_|"
    r"models::(N_\w+::)?(measure_ranges|add_noise|measure|drops_neighbours|dropped_points|list_dropped)\(|"
    r"sim::.*::(sense|sweep_lidar)\(|sim::retake_scan\(|fill_scan",
    "odometry and localization model": r"measure_odometry|measure_all|correct_localization|localized_pose|"
    r"update_belief|Agent::(map_from_base|correct)\(",
    "agent and gate": r"env::Agent::|threewe::safety::",  # before physics, whose types they take
    "physics": r"threewe::sim::",
    "task": r"threewe::task::",
    "observation writing": r"Impl::observe|env::put|env::Pictures",
    "autoreset": r"Impl::(begin|begin_world|clear_outcomes)\(|next_episode",
    "clock and bookkeeping": r"Batch::Impl::|env::Clock::",
    "dispatch over threads": r"env::Workers|env::Batch::step|env::check_actions",
}
PYTHON = "Python"
MANY = 1024  # environments
LINE = 64  # bytes of a cache's line
CACHES = ("--I1=32768,8,64", "--D1=32768,8,64", "--LL=524288,8,64")  # a core's own: bytes, ways, bytes of a line
ROUNDS = 30  # of passing costs on to callers: longer than any chain of calls between parts
Costs = list[float]


def breakdown(kinds: list[Kind]) -> None:
    """Prints a table: instructions of one step by part, and what misses the caches that callgrind models: instructions
    and data the nearest, data the last.
    """
    for kind in kinds:
        parts = measure_parts(kind)
        total = [sum(costs) for costs in zip(*parts.values(), strict=True)]
        columns = ("instructions", "L1 misses", "LL misses", "cycles, guess")
        print(f"\n{describe(kind)}: of one step\n{'part':34}{''.join(f'{column:>14}' for column in columns)}")
        for part in [*PARTS, PYTHON]:
            print(row(part, parts[part]))
        print(row("all", total))
        by_perf = count_by_perf(kind)
        if by_perf:
            print(f"by perf: {by_perf[0]:,.0f} cycles, {by_perf[1]:.2f} misses of the last cache")
        else:
            print(f"perf reads no counters here: a cycle an instruction, {NEAREST} an L1 miss, {LAST} an LL miss")
        if kind.envs >= MANY:
            touched = LINE * (total[2] - parts[PYTHON][2]) / 1024.0
            print(f"memory that a step touches: {touched:.2f} KiB, wanted 1", flush=True)


def row(name: str, costs: Costs) -> str:
    """Of the table."""
    cycles = costs[0] + NEAREST * costs[1] + LAST * costs[2]
    return f"{name:34}{costs[0]:14,.0f}{costs[1]:14,.1f}{costs[2]:14,.2f}{cycles:14,.0f}"


def describe(kind: Kind) -> str:
    """In a few words."""
    seen = f"{kind.beams} beams" if kind.beams else "goal alone"
    more = [f"{name} {value}" for name, value in kind.options.items()]
    if kind.threads > 1:
        more.append(f"{kind.threads} threads")
    return ", ".join([f"{kind.envs} environments", seen, f"{kind.ticks} ticks", kind.noise, f"gate {kind.gate}", *more])


def measure_parts(kind: Kind) -> dict[str, Costs]:
    """Instructions, misses of the nearest cache and of data in the last, by part of one step."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "callgrind.out"
        options = ["--tool=callgrind", "--instr-atstart=no", "--cache-sim=yes", *CACHES, f"--callgrind-out-file={out}"]
        try:
            subprocess.run(["valgrind", *options, *process_of(kind)], capture_output=True, check=True)
        except FileNotFoundError:
            raise SystemExit("--breakdown counts with callgrind: apt-get install valgrind") from None
        own, calls = read_costs(out.read_text())
    shares = shares_of_parts(own, calls)
    parts: dict[str, Costs] = {part: [0.0, 0.0, 0.0] for part in [*PARTS, PYTHON]}
    for function, costs in own.items():
        for part, share in shares[function].items():
            for i, cost in enumerate(costs):
                parts[part][i] += share * cost / (STEPS * kind.envs)
    return parts


def count_by_perf(kind: Kind) -> list[float] | None:
    """`EVENTS` of one step: of many steps more, so that what comes before them falls out. None where perf has none."""
    if not shutil.which("perf"):
        return None
    counted = []
    for steps in (STEPS, STEPS + STEPS_FOR_PERF // kind.envs):
        command = ["perf", "stat", "-x,", "-e", ",".join(EVENTS), *process_of(kind), str(steps)]
        lines = subprocess.run(command, capture_output=True, text=True).stderr.splitlines()
        counts = [line.split(",")[0] for line in lines if any(f",{event}," in line for event in EVENTS)]
        if len(counts) < len(EVENTS) or not all(count.isdigit() for count in counts):
            return None
        counted.append([int(count) for count in counts])
    few, many = counted
    return [(b - a) / (STEPS_FOR_PERF // kind.envs * kind.envs) for a, b in zip(few, many, strict=True)]


def process_of(kind: Kind) -> list[str]:
    """The command that takes steps to count."""
    return [sys.executable, __file__, json.dumps(asdict(kind))]


def read_costs(text: str) -> tuple[dict[str, Costs], dict[str, dict[str, float]]]:
    """What each function costs itself; and for each the instructions of its calls, by caller."""
    names: dict[str, str] = {}
    own: dict[str, Costs] = defaultdict(lambda: [0.0, 0.0, 0.0])
    calls: dict[str, dict[str, float]] = defaultdict(lambda: defaultdict(float))
    events: list[str] = []
    function = callee = ""
    of_call = False

    def named(reference: str) -> str:
        number, _, name = reference.partition(" ")
        if name:
            names[number] = re.sub(r"'\d+$", "", name)  # recursion
        return names[number]

    for line in text.splitlines():
        if line.startswith("events:"):
            events = line.split()[1:]
        elif line.startswith("fn="):
            function = named(line[3:])
        elif line.startswith("cfn="):
            callee = named(line[4:])
        elif line.startswith("calls="):
            of_call = True
        elif line[:1].isdigit() or line[:1] in "+-*":
            counted = dict(zip(events, map(int, line.split()[1:]), strict=False))
            if of_call:
                calls[callee][function] += counted.get("Ir", 0)
            else:
                nearest = sum(counted.get(event, 0) for event in ("I1mr", "D1mr", "D1mw"))
                last = sum(counted.get(event, 0) for event in ("DLmr", "DLmw"))
                for i, cost in enumerate((counted.get("Ir", 0), nearest, last)):
                    own[function][i] += cost
            of_call = False
    return own, calls


def shares_of_parts(own: dict[str, Costs], calls: dict[str, dict[str, float]]) -> dict[str, dict[str, float]]:
    """How much of a function's cost is each part's."""
    shares = {function: {part_of(function) or PYTHON: 1.0} for function in {*own, *calls}}
    for _ in range(ROUNDS):
        for function, callers in calls.items():
            cost = sum(callers.values())
            if part_of(function) or cost == 0.0:
                continue
            mixed: dict[str, float] = defaultdict(float)
            for caller, instructions in callers.items():
                for part, share in shares.get(caller, {PYTHON: 1.0}).items():
                    mixed[part] += share * instructions / cost
            shares[function] = mixed
    return shares


def part_of(function: str) -> str | None:
    """By its name alone."""
    return next((part for part, pattern in PARTS.items() if re.search(pattern, function)), None)


def run_counted(kind: Kind) -> None:
    """In the process that callgrind watches: counts some steps, after as many to warm up."""
    env = kind.make()
    actions = actions_of(kind.envs)
    on, off = (Switch(state) for state in ("on", "off"))
    take_steps(env, actions, STEPS)
    on.turn()
    take_steps(env, actions, STEPS)
    off.turn()


def take_steps(env: VectorEnv, actions: list[NDArray[np.float32]], steps: int) -> None:
    """Each action for ten steps."""
    for step in range(steps):
        env.step(actions[step // 10 % len(actions)])


class Switch:
    """Turns counting on or off: a process that waits until then, for starting one costs as much as many steps."""

    def __init__(self, state: str) -> None:
        command = f"read turn; exec callgrind_control -i {state} {os.getpid()}"
        self.process = subprocess.Popen(["sh", "-c", command], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL)

    def turn(self) -> None:
        """Once."""
        assert self.process.stdin
        self.process.stdin.close()
        if self.process.wait() != 0:
            raise SystemExit("callgrind_control failed")


if __name__ == "__main__":
    kind = Kind(**json.loads(sys.argv[1]))
    if len(sys.argv) == 2:
        run_counted(kind)
    else:
        take_steps(kind.make(), actions_of(kind.envs), int(sys.argv[2]))
