"""Runner of jobs on a Ray cluster: the driver's journal, not Ray, is what nothing gets lost from.

A worker of the cluster has a process of its own for the jobs, as one of this machine: their limits of time and memory
are there, where no job waits.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from threewe._extras import needed_for
from threewe.benchmark.runner import KILLED, Finished, Job, Journal, OnFinished, Worker


@dataclass
class _Running:
    """A job that Ray was given."""

    place: int  # among all jobs
    attempt: int = 1


def run_on_ray(
    jobs: Sequence[Job],
    workers: int,
    journal: Journal | None = None,
    *,
    address: str | None = None,
    memory: int | None = None,
    on_done: OnFinished = lambda *_: None,
) -> list[Finished]:
    """As `runner.run_jobs`, with `workers` jobs at a time wherever the cluster has a processor.

    A job whose worker or node is gone begins again elsewhere; one that loses three is itself at fault. `address` is of
    a cluster whose nodes have the same installation; without one, a cluster on this machine is started, and ended.
    """
    with cluster(address) as ray:
        return _Driver(ray, jobs, workers, journal, memory, on_done).run()


@contextmanager
def cluster(address: str | None = None) -> Iterator[Any]:
    """The module `ray`, connected to a cluster at an address, to one that is started here without, or as it is already.

    Workers find what this process imports. Raises ConfigError where Ray is missing.
    """
    with needed_for("engine ray", "ray"):
        import ray
    begins_here = not ray.is_initialized()
    if begins_here:
        ray.init(address=address, log_to_driver=False, runtime_env={"env_vars": {"PYTHONPATH": ":".join(sys.path)}})
    try:
        yield ray
    finally:
        if begins_here:
            ray.shutdown()


class _Driver:
    """Keeps as many jobs under way as there are workers, and writes down each that finishes."""

    def __init__(
        self,
        ray: Any,
        jobs: Sequence[Job],
        workers: int,
        journal: Journal | None,
        memory: int | None,
        on_done: OnFinished,
    ) -> None:
        self._ray, self._jobs, self._workers = ray, jobs, workers
        self._journal, self._memory, self._on_done = journal, memory, on_done
        self._task = ray.remote(num_cpus=1, max_retries=0)(_do)
        self._found: dict[int, Finished] = {}
        self._running: dict[Any, _Running] = {}

    def run(self) -> list[Finished]:
        waiting = [i for i, job in enumerate(self._jobs) if not self._is_known(i, job)]
        waiting.reverse()
        while waiting or self._running:
            while waiting and len(self._running) < self._workers:
                self._begin(_Running(waiting.pop()))
            ready, _ = self._ray.wait(list(self._running), num_returns=1)
            for reference in ready:
                self._finish(reference)
        return [self._found[i] for i in range(len(self._jobs))]

    def _is_known(self, place: int, job: Job) -> bool:
        known = self._journal.find(job.key) if self._journal is not None else None
        if known is not None:
            self._found[place] = known
            self._on_done(job, known)
        return known is not None

    def _begin(self, running: _Running) -> None:
        self._running[self._task.remote(self._jobs[running.place], self._memory)] = running

    def _finish(self, reference: Any) -> None:
        running = self._running.pop(reference)
        try:
            finished = self._ray.get(reference)
        except self._ray.exceptions.RayError as error:
            if running.attempt < KILLED:
                self._begin(replace(running, attempt=running.attempt + 1))
                return
            finished = Finished({}, f"its process died: {type(error).__name__}", own=True)
        job = self._jobs[running.place]
        self._found[running.place] = finished
        if self._journal is not None:
            self._journal.add(job.key, finished)
        self._on_done(job, finished)


def _do(job: Job, memory: int | None) -> Finished:
    """What a worker of the cluster does."""
    return _process(memory).run(job)


@cache
def _process(memory: int | None) -> Worker:
    """The one for jobs, in each worker of the cluster."""
    return Worker(memory)
