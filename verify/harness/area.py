"""Experiments of any areas: their cases are run, their rows judged and printed, their results kept where asked."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from verify.cases.trees import ROOT
from verify.harness import claims
from verify.harness.journal import CaseJournal, Revision
from verify.harness.rows import Row, Verdict
from verify.harness.running import Cases, Experiment, run_cases


@dataclass(frozen=True)
class Options:
    """How much is run, and what is kept of it."""

    seed: int | None = None  # by default from the commit
    count: int | None = None  # of cases of each experiment
    deadline: float = math.inf  # of the monotonic clock: no case begins after it
    write: bool = False
    write_model: bool = False


def verify(experiments: Sequence[tuple[str, Experiment]], options: Options) -> Counter[str]:
    """Runs experiments, each with its area's name, in this order; how many rows came to each status."""
    revision = Revision.here()
    seed = revision.seed if options.seed is None else options.seed
    print(f"commit {revision.commit}, seed {seed}", flush=True)
    journals: dict[str, CaseJournal] = {}
    statuses: Counter[str] = Counter()
    for done, (area, experiment) in enumerate(experiments):
        if area not in journals:
            path = ROOT / f"build/verify/{area}-{revision.commit}-{seed}.jsonl"
            journals[area] = CaseJournal(path, options.deadline)
        cases = run_cases(experiment, seed, options.count or experiment.cases, journals[area])
        if not cases.all:
            print(f"\nout of time: {len(experiments) - done} experiments were not begun", flush=True)
            return statuses + Counter({"not shown": len(experiments) - done})
        complete = len(cases.all) >= experiment.cases
        verdicts = [(row, verdict_of(row, cases, complete)) for row in experiment.rows]
        show(area, experiment, cases, verdicts)
        statuses += Counter(verdict.status for _, verdict in verdicts)
        if options.write_model and experiment.learn and complete and not cases.broken:
            experiment.learn(cases.all, revision.commit, seed)
        if options.write and complete:
            claims.save(area, experiment, revision, seed, verdicts)
    return statuses


def verdict_of(row: Row, cases: Cases, complete: bool) -> Verdict:
    """The row's verdict; `not shown` where no case could be run here."""
    if not cases.shown:
        return Verdict(cases.all[0]["not_shown"], row.target, "not shown")
    return row.judge(cases.shown, complete=complete)


def show(area: str, experiment: Experiment, cases: Cases, verdicts: list[tuple[Row, Verdict]]) -> None:
    """A line for each row: status, what, figure, target, interval, and what would be caught nine times in ten."""
    missing = f" of {experiment.cases}" if len(cases.all) < experiment.cases else ""
    print(f"\n{area}, {experiment.name}: {len(cases.all)}{missing} cases, {cases.seconds:.0f} s")
    for row, verdict in verdicts:
        power = f"catches {verdict.power}" if verdict.power else ""
        words = [f"{verdict.status:10}", f"{row.name:60}", verdict.figure, verdict.target, verdict.interval, power]
        print("  ".join(word for word in words if word), flush=True)
