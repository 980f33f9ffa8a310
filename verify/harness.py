"""Runs the cases behind a claim, two at a time, keeps each result, and prints a row per claim."""

import faulthandler
import hashlib
import json
import math
import statistics
import subprocess
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from multiprocessing import get_context
from pathlib import Path
from queue import Queue
from threading import Lock
from typing import Any

from verify.cases.trees import ROOT

Case = dict[str, Any]


@dataclass
class Verdict:
    """What a row comes to."""

    figure: str
    target: str
    status: str  # "pass", "FAIL", "told" where nothing is asked, or "not shown"
    interval: str = ""


@dataclass
class Row:
    """One claim: `judge(cases, sample)` makes a figure out of the cases and says whether it holds."""

    name: str
    judge: Callable[[list[Case], bool], Verdict]


@dataclass
class Experiment:
    """`run(seed, **arguments)` is one case; `rows` are the claims that its cases decide."""

    name: str
    run: Callable[..., Case]
    arguments: Case = field(default_factory=dict)
    cases: int = 1
    sample: int = 1  # of them with --sample; 0 leaves the experiment out
    rows: list[Row] = field(default_factory=list)
    alone: bool = False  # one case at a time, for those that measure time
    limit: float = 900.0  # [s] of wall time, after which a case counts as hanging
    learn: Callable[[list[Case], str, int], None] | None = None  # with --write-model: from cases, commit and seed

    def seeds(self, seed: int, count: int) -> Iterator[int]:
        """The seeds of its first cases: the same whatever else runs."""
        for index in range(count):
            digest = hashlib.sha256(f"{seed}/{self.name}/{index}".encode()).digest()
            yield int.from_bytes(digest[:4], "little")


def share_of(name: str, holds: Callable[[Case], bool], *, at_least: float) -> Row:
    """The share of cases in which something holds, with its Wilson interval."""

    def judge(cases: list[Case], sample: bool) -> Verdict:
        hits = sum("error" not in case and holds(case) for case in cases)
        return verdict_on_share(hits, len(cases), at_least, sample)

    return Row(name, judge)


def verdict_on_share(hits: int, count: int, at_least: float, sample: bool) -> Verdict:
    """Of a sample: whether it contradicts the claim."""
    low, high = wilson(hits, count)
    passed = chance_of_so_few(hits, count, at_least) >= BY_CHANCE if sample else hits / count >= at_least
    status = "pass" if passed else "FAIL"
    return Verdict(f"{hits}/{count} = {hits / count:.1%}", f">= {at_least:.1%}", status, f"[{low:.1%}, {high:.1%}]")


def chance_of_so_few(hits: int, count: int, share: float) -> float:
    """That of so many no more succeed, when a share of all does: the binomial's tail, exact where the share is near 1
    and intervals made of deviations are far too narrow."""
    return sum(math.comb(count, k) * share**k * (1.0 - share) ** (count - k) for k in range(hits + 1))


def all_of(name: str, holds: Callable[[Case], bool]) -> Row:
    """Something holds in every case."""
    return share_of(name, holds, at_least=1.0)


def mean_of(name: str, value: Callable[[Case], float], **target: float) -> Row:
    """The mean over the cases is `at_least` or `at_most` something."""
    return _figure(name, value, statistics.fmean, "mean", target)


def median_of(name: str, value: Callable[[Case], float], **target: float) -> Row:
    """The median over the cases is `at_least` or `at_most` something; of a sample the best, for what else runs on the
    machine makes timings worse and never better.
    """
    best = max if "at_least" in target else min
    return _figure(name, value, statistics.median, "median", target, best)


def worst_of(name: str, value: Callable[[Case], float], **target: float) -> Row:
    """Every case is `at_least` or `at_most` something; the figure is the worst of them."""
    return _figure(name, value, min if "at_least" in target else max, "worst", target)


BY_CHANCE = 0.0005
"""A sample fails only when what it shows has less than this chance: it has some hundred rows."""


def student(freedom: int) -> float:
    """What 95 % of Student's t lie within, wider for few cases (Abramowitz and Stegun 1964, 26.7.5)."""
    z, n = 1.95996, max(freedom, 1)
    return z + (z**3 + z) / (4.0 * n) + (5.0 * z**5 + 16.0 * z**3 + 3.0 * z) / (96.0 * n * n)


def ratio_of(name: str, value: Callable[[Case], float], reference: Callable[[Case], float], *, at_least: float) -> Row:
    """The mean over the cases, as a share of the mean of a reference in the same cases, with its 95 % interval."""

    def judge(cases: list[Case], sample: bool) -> Verdict:
        failures = sum("error" in case for case in cases)
        wanted = f">= {at_least:g}"
        if failures:
            return Verdict(f"{failures} of {len(cases)} cases broke", wanted, "FAIL")
        values, references = [value(case) for case in cases], [reference(case) for case in cases]
        mean, of = statistics.fmean(values), statistics.fmean(references)
        ratio = mean / of
        misfits = [v - ratio * r for v, r in zip(values, references, strict=True)]
        deviation = statistics.stdev(misfits) if len(cases) > 1 else math.inf
        spread = student(len(cases) - 1) * deviation / (of * math.sqrt(len(cases)))
        low, high = ratio - spread, ratio + spread
        holds = (high if sample else ratio) >= at_least
        figure = f"mean {mean:.3f} of {of:.3f} = {ratio:.3f}"
        return Verdict(figure, wanted, "pass" if holds else "FAIL", f"[{low:.3f}, {high:.3f}]")

    return Row(name, judge)


def mean_of_all(name: str, values: Callable[[Case], list[float]], *, at_least: float) -> Row:
    """The mean over all values of all cases, with its 95 % interval; a sample fails where all of that is below."""

    def judge(cases: list[Case], sample: bool) -> Verdict:
        wanted = f">= {at_least:g}"
        if any("error" in case for case in cases):
            return Verdict("cases broke", wanted, "FAIL")
        every = [value for case in cases for value in values(case)]
        mean = statistics.fmean(every)
        spread = student(len(every) - 1) * statistics.stdev(every) / math.sqrt(len(every))
        holds = (mean + spread if sample else mean) >= at_least
        interval = f"[{mean - spread:.3f}, {mean + spread:.3f}]"
        return Verdict(f"mean {mean:.3f} of {len(every)}", wanted, "pass" if holds else "FAIL", interval)

    return Row(name, judge)


def mean_share(name: str, value: Callable[[Case], float], *, at_most: float) -> Row:
    """The mean share over the cases, with its 95 % interval where there are several."""

    def judge(cases: list[Case], sample: bool) -> Verdict:
        wanted = f"<= {at_most:.0%}"
        if any("error" in case for case in cases):
            return Verdict("cases broke", wanted, "FAIL")
        values = [value(case) for case in cases]
        mean, low, interval = statistics.fmean(values), 0.0, ""
        if len(values) > 1:
            spread = student(len(values) - 1) * statistics.stdev(values) / math.sqrt(len(values))
            low = max(mean - spread, 0.0)
            interval = f"[{low:.2%}, {mean + spread:.2%}]"
        holds = (low if sample and interval else mean) <= at_most
        return Verdict(f"{mean:.2%}", wanted, "pass" if holds else "FAIL", interval)

    return Row(name, judge)


def told(name: str, figure: Callable[[list[Case]], str]) -> Row:
    """A figure beside those that have a target."""

    def judge(cases: list[Case], _: bool) -> Verdict:
        if any("error" in case for case in cases):
            return Verdict("cases broke", "", "FAIL")
        return Verdict(figure(cases), "", "told")

    return Row(name, judge)


def _figure(
    name: str,
    value: Callable[[Case], float],
    summary: Callable[[list[float]], float],
    word: str,
    target: dict[str, float],
    of_sample: Callable[[list[float]], float] | None = None,
) -> Row:
    ((sense, bound),) = target.items()
    at_least = {"at_least": True, "at_most": False}[sense]

    def judge(cases: list[Case], sample: bool) -> Verdict:
        failures = sum("error" in case for case in cases)
        wanted = f"{'>=' if at_least else '<='} {bound:g}"
        if failures:
            return Verdict(f"{failures} of {len(cases)} cases broke", wanted, "FAIL")
        chosen, told = (of_sample, "best") if sample and of_sample else (summary, word)
        figure = chosen([value(case) for case in cases])
        holds = figure >= bound if at_least else figure <= bound
        return Verdict(f"{told} {figure:.4g} of {len(cases)}", wanted, "pass" if holds else "FAIL")

    return Row(name, judge)


def wilson(hits: int, count: int, z: float = 1.959964) -> tuple[float, float]:
    """The 95 % interval of a proportion (E. B. Wilson, 1927)."""
    share = hits / count
    middle = share + z * z / (2 * count)
    spread = z * math.sqrt(share * (1 - share) / count + z * z / (4 * count * count))
    scale = 1 + z * z / count
    low, high = (middle - spread) / scale, (middle + spread) / scale
    return (low if hits > 0 else 0.0), (high if hits < count else 1.0)  # exact at the ends, where rounding is not


def verify(
    area: str,
    experiments: list[Experiment],
    *,
    seed: int | None = None,
    count: int | None = None,
    sample: bool = False,
    write_model: bool = False,
    page: Path | None = None,
) -> list[str]:
    """Runs an area's experiments, writes a model where one is learned, prints the rows and writes them into a page; the
    status of each.
    """
    commit, default_seed = revision()
    seed = default_seed if seed is None else seed
    print(f"\nverify {area}: commit {commit}, seed {seed}", flush=True)
    journal = Journal(ROOT / f"build/verify/{area}-{commit}-{seed}.jsonl")
    judged = []
    for experiment in experiments:
        cases = run_cases(experiment, seed, count or (experiment.sample if sample else experiment.cases), journal)
        if not cases:  # too long for a sample
            continue
        if write_model and experiment.learn:
            experiment.learn(cases, commit, seed)
        shown = [case for case in cases if "not_shown" not in case]
        for row in experiment.rows:
            verdict = row.judge(shown, sample) if shown else Verdict(cases[0]["not_shown"], "", "not shown")
            print_row(f"{experiment.name}: {row.name}", verdict)
            judged.append((experiment.name, row.name, verdict))
    if page:
        write_into(page, f"`./dev verify {area} --seed {seed}`, commit {commit}", judged)
    return [verdict.status for _, _, verdict in judged]


BEGINNING, END = "<!-- figures: begin -->\n", "<!-- figures: end -->"


def write_into(page: Path, origin: str, judged: list[tuple[str, str, Verdict]]) -> None:
    """Puts a table for each experiment between the two marks of a page, in place of what stands there."""
    before, beginning, rest = page.read_text().partition(BEGINNING)
    _, end, after = rest.partition(END)
    if not (beginning and end):
        raise ValueError(f"{page} has no two lines '{BEGINNING.strip()}' and '{END}'")
    lines = [f"From {origin}.", ""]
    for name in dict.fromkeys(experiment for experiment, _, _ in judged):
        lines += [f"**{name}**", "", "| | figure | target | 95 % |", "|---|---|---|---|"]
        for _, row, verdict in (one for one in judged if one[0] == name):
            missed = " **missed**" if verdict.status == "FAIL" else ""
            figure = verdict.figure if verdict.status != "not shown" else f"not shown: {verdict.figure}"
            lines.append(f"| {row} | {figure}{missed} | {verdict.target} | {verdict.interval} |")
        lines.append("")
    page.write_text(before + BEGINNING + "\n".join(lines) + END + after)


def print_row(name: str, verdict: Verdict) -> None:
    """One line: what, figure, target, interval, status."""
    words = [f"{verdict.status:9}", f"{name:60}", verdict.figure, verdict.target, verdict.interval]
    print("  ".join(word for word in words if word), flush=True)


def run_cases(experiment: Experiment, seed: int, count: int, journal: "Journal") -> list[Case]:
    """Runs those cases that the journal lacks, each in one of two processes."""
    processes = 1 if experiment.alone else 2
    idle: Queue[Worker] = Queue()
    for _ in range(processes):
        idle.put(Worker())

    def one(case_seed: int) -> Case:
        known = journal.find(experiment.name, case_seed)
        if known is not None:
            return known
        start = time.monotonic()
        worker = idle.get()
        case = worker.run(experiment, case_seed)
        idle.put(worker)
        journal.add(experiment.name, case_seed, case, time.monotonic() - start)
        return case

    with ThreadPoolExecutor(processes) as threads:
        cases = list(threads.map(one, experiment.seeds(seed, count)))
    while not idle.empty():
        idle.get().stop()
    return cases


class Worker:
    """A process that runs cases one after another, replaced when one kills it."""

    def __init__(self) -> None:
        """A fresh process."""
        self.pool = ProcessPoolExecutor(1, mp_context=get_context("spawn"))

    def run(self, experiment: Experiment, seed: int) -> Case:
        """One case; {"error": ...} if it raises, dies or hangs."""
        try:
            return self.pool.submit(run_case, experiment.run, seed, experiment.arguments, experiment.limit).result()
        except BrokenProcessPool:
            self.pool = ProcessPoolExecutor(1, mp_context=get_context("spawn"))
            return {"error": f"its process died, or took longer than {experiment.limit:g} s"}

    def stop(self) -> None:
        """Ends the process."""
        self.pool.shutdown()


def run_case(function: Callable[..., Case], seed: int, arguments: Case, limit: float) -> Case:
    """Runs one case in this process, which ends with it if that takes too long."""
    faulthandler.dump_traceback_later(limit, exit=True)
    try:
        return function(seed, **arguments)
    except Exception:
        return {"error": traceback.format_exc()}
    finally:
        faulthandler.cancel_dump_traceback_later()


class Journal:
    """The cases that have finished, one JSON line each. Those that broke or were not shown are run again next time."""

    def __init__(self, path: Path) -> None:
        """Reads what there is."""
        self.path = path
        self.lock = Lock()
        self.known: dict[tuple[str, int], Case] = {}
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.exists():
            complete = path.read_text().rpartition("\n")[0]  # the last line may have been cut off
            path.write_text(complete + "\n" if complete else "")
            lines = [json.loads(line) for line in complete.splitlines()]
            finished = [line for line in lines if not {"error", "not_shown"} & line["case"].keys()]
            self.known = {(line["experiment"], line["seed"]): line["case"] for line in finished}
            print(f"{len(self.known)} cases were finished before")

    def find(self, experiment: str, seed: int) -> Case | None:
        """A finished case."""
        return self.known.get((experiment, seed))

    def add(self, experiment: str, seed: int, case: Case, seconds: float) -> None:
        """Writes a case down, and shows what broke."""
        if "error" in case:
            print(f"{experiment}, seed {seed}: {case['error']}", file=sys.stderr, flush=True)
        line = {"experiment": experiment, "seed": seed, "seconds": round(seconds, 3), "case": case}
        with self.lock, self.path.open("a") as file:
            file.write(json.dumps(line) + "\n")


def revision() -> tuple[str, int]:
    """The commit, with a hash of what is not committed, and the seed that follows from the commit."""

    def git(*arguments: str) -> str:
        return subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True).stdout.strip()

    commit = git("rev-parse", "--short=10", "HEAD") or "0"
    changes = git("diff", "HEAD") + git("ls-files", "--others", "--exclude-standard")
    suffix = f"+{hashlib.sha256(changes.encode()).hexdigest()[:6]}" if changes else ""
    return commit + suffix, int(commit[:8], 16)
