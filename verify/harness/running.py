"""Experiments, and how their cases are run: two at a time, each in a process that may die of it."""

import faulthandler
import time
import traceback
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from multiprocessing import get_context
from queue import Queue

from verify.harness.journal import Journal, seeds
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
    sample: int = 1  # of them with --sample; 0 leaves the experiment out
    rows: list[Row] = field(default_factory=list)
    alone: bool = False  # one case at a time, for those that measure time
    limit: float = 900.0  # [s] of wall time, after which a case counts as hanging
    learn: Callable[[list[Case], str, int], None] | None = None  # with --write-model: from cases, commit and seed

    def arguments_of(self, index: int) -> Case:
        """Of the case with that index."""
        return {**self.arguments, **self.variants[index % len(self.variants)]}


@dataclass(frozen=True)
class Cases:
    """What came of an experiment's cases, and the seconds that they took in all."""

    all: list[Case]
    seconds: float

    @property
    def shown(self) -> list[Case]:
        """Without those that cannot be run here."""
        return [case for case in self.all if "not_shown" not in case]


def run_cases(experiment: Experiment, seed: int, count: int, journal: Journal) -> Cases:
    """Runs those cases that the journal lacks, each in one of two processes."""
    processes = 1 if experiment.alone else 2
    idle: Queue[Worker] = Queue()
    for _ in range(processes):
        idle.put(Worker())

    def one(index: int, case_seed: int) -> tuple[Case, float]:
        known = journal.find(experiment.name, case_seed)
        if known is not None:
            return known
        worker = idle.get()
        start = time.monotonic()
        case = worker.run(experiment, index, case_seed)
        idle.put(worker)
        seconds = time.monotonic() - start
        journal.add(experiment.name, case_seed, case, seconds)
        return case, seconds

    with ThreadPoolExecutor(processes) as threads:
        found = list(threads.map(one, range(count), seeds(seed, experiment.name, count)))
    while not idle.empty():
        idle.get().stop()
    return Cases([case for case, _ in found], sum(seconds for _, seconds in found))


class Worker:
    """A process that runs cases one after another, replaced when one kills it."""

    def __init__(self) -> None:
        """A fresh process."""
        self.pool = ProcessPoolExecutor(1, mp_context=get_context("spawn"))

    def run(self, experiment: Experiment, index: int, seed: int) -> Case:
        """One case; {"error": ...} if it raises, dies or hangs."""
        arguments = experiment.arguments_of(index)
        try:
            return self.pool.submit(run_case, experiment.run, seed, arguments, experiment.limit).result()
        except BrokenProcessPool:
            self.pool = ProcessPoolExecutor(1, mp_context=get_context("spawn"))
            return {"error": f"its process died, or took longer than {experiment.limit:g} s"}
        except Exception:  # what came back could not be sent, or was no case
            return {"error": traceback.format_exc()}

    def stop(self) -> None:
        """Ends the process."""
        self.pool.shutdown()


def run_case(function: Callable[..., Case], seed: int, arguments: Case, limit: float) -> Case:
    """Runs one case in this process, which ends with it if that takes too long."""
    faulthandler.dump_traceback_later(limit, exit=True)
    try:
        return {**named(arguments), **function(seed, **arguments)}
    except Exception:
        return {"error": traceback.format_exc()}
    finally:
        faulthandler.cancel_dump_traceback_later()


def named(arguments: Case) -> Case:
    """What the case is about, for rows about some of them."""
    return {key: value for key, value in arguments.items() if isinstance(value, (str, int, float))}
