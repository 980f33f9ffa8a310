"""One area: its experiments are run, its rows judged and printed, and what they saw is kept where that is asked for."""

import math
import time
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

from verify.cases.trees import ROOT
from verify.harness import claims
from verify.harness.journal import Revision, open_journal
from verify.harness.record import Record
from verify.harness.rows import Row, Verdict
from verify.harness.running import Cases, Experiment, run_cases
from verify.harness.sequential import RUNS


@dataclass(frozen=True)
class Options:
    """How much is run, and what is kept of it."""

    seed: int | None = None  # by default from the commit
    count: int | None = None  # of cases of each experiment
    sample: bool = False
    deadline: float = math.inf  # of the monotonic clock: no experiment begins after it
    only: str = ""  # experiments with this in their names
    record: bool = False
    write: bool = False
    write_model: bool = False


@dataclass
class Outcome:
    """How an area went."""

    statuses: Counter[str] = field(default_factory=Counter)
    seconds: float = 0.0  # by the wall


def verify(area: str, experiments: list[Experiment], options: Options) -> Outcome:
    """Runs an area's experiments, prints their rows, and keeps what is to be kept."""
    begun = time.monotonic()
    revision = Revision.here()
    seed = revision.seed if options.seed is None else options.seed
    print(f"\nverify {area}: commit {revision.commit}, seed {seed}", flush=True)
    journal = open_journal(ROOT / f"build/verify/{area}-{revision.commit}-{seed}.jsonl")
    record = Record()
    judged: list[tuple[str, Verdict]] = []
    left_out = 0
    for experiment in (one for one in experiments if options.only in one.name):
        count = options.count or (experiment.sample if options.sample else experiment.cases)
        if count == 0:  # too long for a sample
            continue
        if time.monotonic() > options.deadline:
            print(f"{'not shown':10}  {experiment.name}: out of time", flush=True)
            left_out += 1
            continue
        cases = run_cases(experiment, seed, count, journal)
        if options.write_model and experiment.learn and not cases.broken:
            experiment.learn(cases.all, revision.commit, seed)
        verdicts: list[tuple[Row, Verdict]] = []
        for row in (one for one in experiment.rows if not (options.sample and one.full_only)):
            earlier = record.earlier(area, name_of(experiment, row), revision.commit, seed)
            verdict = judge(row, cases, sample=options.sample, earlier=earlier)
            print_row(name_of(experiment, row), verdict, cost(cases, verdict, options.sample))
            verdicts.append((row, verdict))
        if options.write:
            claims.save(area, experiment, revision, seed, verdicts, len(cases.all))
        judged += [(name_of(experiment, row), verdict) for row, verdict in verdicts]
    if options.record:
        record.add(area, revision.commit, seed, dict(judged))
    statuses = Counter(verdict.status for _, verdict in judged)
    return Outcome(statuses + Counter({"not shown": left_out}), time.monotonic() - begun)


def judge(row: Row, cases: Cases, **how: Any) -> Verdict:
    """The row's verdict; `not shown` where no case could be run here."""
    return row.judge(cases.shown, **how) if cases.shown else Verdict(cases.all[0]["not_shown"], "", "not shown")


def name_of(experiment: Experiment, row: Row) -> str:
    return f"{experiment.name}: {row.name}"


def cost(cases: Cases, verdict: Verdict, sample: bool) -> str:
    """What such a power costs."""
    if not verdict.power or not verdict.seen:
        return ""
    runs = f"{RUNS} x " if sample else ""
    return f"({runs}{len(cases.all)} cases, {runs}{cases.seconds:.0f} s)"


def print_row(name: str, verdict: Verdict, cost: str) -> None:
    """One line: status, what, figure, target, interval, and what would be caught nine times in ten, at what cost."""
    power = f"catches {verdict.power} {cost}".rstrip() if verdict.power else ""
    words = [f"{verdict.status:10}", f"{name:60}", verdict.figure, verdict.target, verdict.interval, power]
    print("  ".join(word for word in words if word), flush=True)
