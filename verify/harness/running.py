"""Experiments, and how their cases are run: two at a time, each in a process that may die of it."""

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from threewe.benchmark.runner import Finished, Job, run_jobs

from verify.harness.journal import OUT_OF_TIME, CaseJournal, seeds
from verify.harness.rows import Case, Row


@dataclass
class Experiment:
    """`run(seed, **arguments)` is one case; `rows` are the claims that its cases decide.

    Where there are `variants`, such as scenes, cases take turns in them, and all decide the same rows.
    """

    name: str
    run: Callable[..., Case]
    arguments: Case = field(default_factory=dict)
    variants: Sequence[Case] = ({},)  # more arguments, one of them for each case
    cases: int = 1
    rows: list[Row] = field(default_factory=list)
    alone: bool = False  # one case at a time, for those that measure time
    at_once: int = 2  # cases at a time; more of those that are in real time, and wait for most of it
    limit: float = 900.0  # [s] of wall time, after which a case counts as hanging
    by_night: bool = True  # in drawn runs; False where it takes all of a night, or times the wall
    learn: Callable[[list[Case], str, int], None] | None = None  # with --write-model: from cases, commit and seed

    def arguments_of(self, index: int) -> Case:
        """Of the case with that index."""
        return {**self.arguments, **self.variants[index % len(self.variants)]}


@dataclass(frozen=True)
class Cases:
    """What came of an experiment's cases that have finished, and the seconds that they took in all."""

    all: list[Case]
    seconds: float

    @property
    def shown(self) -> list[Case]:
        """Without those that cannot be run here."""
        return [case for case in self.all if "not_shown" not in case]

    @property
    def broken(self) -> list[Case]:
        """Those that raised, died, or came to nothing."""
        return [case for case in self.all if "error" in case]


def run_cases(experiment: Experiment, seed: int, count: int, journal: CaseJournal) -> Cases:
    """Runs those cases that the journal lacks, each in a process that others run beside."""
    drawn = list(seeds(seed, experiment.name, count))
    jobs = [
        Job(
            f"{experiment.name}, seed {case_seed}",
            run_case,
            {"function": experiment.run, "seed": case_seed, "arguments": experiment.arguments_of(index)},
            experiment.limit,
        )
        for index, case_seed in enumerate(drawn)
    ]
    found = run_jobs(jobs, 1 if experiment.alone else experiment.at_once, journal, on_done=show_failure)
    found = [one for one in found if one is not OUT_OF_TIME]
    cases = [{"error": one.failure} if one.failure else one.result for one in found]
    return Cases(cases, sum(one.seconds for one in found))


def show_failure(job: Job, finished: Finished) -> None:
    """What broke is seen at once."""
    if finished.failure and finished is not OUT_OF_TIME:
        print(f"{job.key}: {finished.failure}", file=sys.stderr, flush=True)


def run_case(function: Callable[..., Case], seed: int, arguments: Case) -> Case:
    """Runs one case, and says what it is about."""
    return {**named(arguments), **function(seed, **arguments)}


def named(arguments: Case) -> Case:
    """What the case is about, for rows about some of them."""
    return {key: value for key, value in arguments.items() if isinstance(value, (str, int, float))}
