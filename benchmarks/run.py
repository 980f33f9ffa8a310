"""Runs the benchmarks on a CPU of their own, after a look at whether the machine is quiet enough to measure on.

.venv/bin/python benchmarks/run.py [name ...] [--option ...]

Options go to scripts, such as `env --breakdown`.
"""

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
PROGRAMS = ROOT / "build" / "dev" / "benchmarks"
SCRIPTS = {path.stem.removesuffix("_bench"): path for path in (ROOT / "benchmarks").glob("*_bench.py")}
RESULTS = ROOT / "benchmarks" / "results"
SPIN = "import time; end = time.monotonic() + 1; n = 0\nwhile time.monotonic() < end: n += 1\nprint(n)"


def main(words: list[str]) -> int:
    """Runs those named, or all; 1 if one is unknown or fails."""
    options = [word for word in words if word.startswith("-")]
    names = [word for word in words if not word.startswith("-")]
    programs = {path.stem.removesuffix("_bench") for path in PROGRAMS.glob("*_bench")}
    known = sorted(programs | set(SCRIPTS))
    if unknown := set(names) - set(known):
        print(f"no benchmark {', '.join(sorted(unknown))}; there are {', '.join(known)}")
        return 1
    if options and (not names or set(names) & programs):
        print(f"{' '.join(options)}: options are for scripts alone: name one of {', '.join(sorted(SCRIPTS))}")
        return 1
    cpu = max(os.sched_getaffinity(0))
    machine = {"cpu": cpu, "cpu_model": cpu_model(), **quietness(cpu)}
    commit = subprocess.run(["git", "describe", "--always", "--dirty"], cwd=ROOT, capture_output=True, text=True)
    print(json.dumps(machine, indent=1))
    RESULTS.mkdir(parents=True, exist_ok=True)
    failed = 0
    for name in names or known:
        raw = RESULTS / f"{name}-{commit.stdout.strip()}.json"
        if name in SCRIPTS:
            failed |= subprocess.run(
                [sys.executable, SCRIPTS[name], "--cpu", str(cpu), "--out", raw, *options]
            ).returncode
            if raw.exists():
                raw.write_text(json.dumps({"machine": machine, **json.loads(raw.read_text())}, indent=1))
        else:
            command = [PROGRAMS / f"{name}_bench", f"--benchmark_out={raw}", "--benchmark_out_format=json"]
            repeated = ["--benchmark_repetitions=5", "--benchmark_display_aggregates_only=true"]
            context = [f"--benchmark_context={key}={str(value).replace(',', ' ')}" for key, value in machine.items()]
            done = subprocess.run([*command, *repeated, *context], preexec_fn=lambda: os.sched_setaffinity(0, {cpu}))
            failed |= done.returncode
            if done.returncode == 0:
                print(*beside_what_is_wanted(json.loads(raw.read_text())), sep="\n")
        if raw.exists():
            print(f"raw results: {raw.relative_to(ROOT)}\n", flush=True)
    return int(failed != 0)


def beside_what_is_wanted(results: dict[str, Any]) -> Iterator[str]:
    """A line for each benchmark that names what is wanted, misses marked."""
    for one in results["benchmarks"]:
        if one.get("aggregate_name") == "median" and "wanted" in one:
            pace, wanted = one["times_real_time"], one["wanted"]
            missed = "" if pace >= wanted else "  MISSED"
            yield f"{one['run_name']}: {pace:.0f} x real time, wanted {wanted:.0f}{missed}"


def quietness(cpu: int) -> dict[str, str]:
    """Whether another CPU shares this one's core, and whether something else runs there already."""
    others = sorted(os.sched_getaffinity(0) - {cpu})
    if not others:
        return {"other_cpus": "there are none"}
    busy = busy_share(others[0])
    (alone,) = spin([cpu])
    beside, _ = spin([cpu, others[0]])
    ratio = beside / alone
    return {
        "other_cpu": f"{busy:.0%} busy" if busy > 0.05 else "idle",
        "speed_beside_a_spinning_cpu": f"{ratio:.2f}",
        "reading": "the two are separate cores" if ratio > 0.85 else "the two share a core: keep the other one idle",
    }


def spin(cpus: list[int]) -> list[int]:
    """Turns of an empty loop in one second, on each of the CPUs at once."""
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", SPIN],
            stdout=subprocess.PIPE,
            preexec_fn=lambda cpu=cpu: os.sched_setaffinity(0, {cpu}),
        )
        for cpu in cpus
    ]
    return [int(process.communicate()[0]) for process in processes]


def busy_share(cpu: int, seconds: float = 0.5) -> float:
    """The share of time in which a CPU has been doing something."""

    def times() -> tuple[int, int]:
        line = next(line for line in Path("/proc/stat").read_text().splitlines() if line.startswith(f"cpu{cpu} "))
        numbers = [int(word) for word in line.split()[1:]]
        return sum(numbers), numbers[3] + numbers[4]

    total, idle = times()
    time.sleep(seconds)
    total_after, idle_after = times()
    return 1 - (idle_after - idle) / max(1, total_after - total)


def cpu_model() -> str:
    """As /proc/cpuinfo calls it."""
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    return next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), "unknown")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
