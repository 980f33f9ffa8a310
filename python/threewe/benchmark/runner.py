"""Runner of many jobs: a process per worker, a journal of what has finished, limits of time and memory."""

from __future__ import annotations

import json
import os
import resource
import signal
import sys
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from multiprocessing import get_context, parent_process
from multiprocessing.connection import Connection
from pathlib import Path
from pickle import PicklingError
from queue import Queue
from threading import Event, Lock, Thread
from typing import Any

from threewe.errors import ConfigError

Result = dict[str, Any]
KILLED = 3  # times that a job is begun whose process a signal ended, before that counts as its own fault


@dataclass(frozen=True)
class Job:
    """One unit of work: a function that can be pickled, and a key that no other job of the run has."""

    key: str
    function: Callable[..., Result]
    arguments: Mapping[str, Any]
    limit: float  # [s] of wall time, after which it counts as hanging


@dataclass(frozen=True)
class Finished:
    """What came of a job."""

    result: Result
    failure: str = ""  # why there is no result
    own: bool = False  # the job's process died or hung, or it used too much memory
    seconds: float = 0.0  # of wall time
    known: bool = field(default=False, compare=False)  # from a journal, before this run


OnFinished = Callable[[Job, Finished], object]
"""Called as each job finishes."""


class Journal:
    """The jobs that have finished, one line of JSON each: an interrupted run goes on from it.

    What failed is written down too, and run again next time.
    """

    def __init__(
        self,
        path: Path,
        run: Mapping[str, Any] | None = None,
        keeps: Callable[[Result], bool] = lambda _: True,
    ) -> None:
        """Reads what there is. `run` says what the journal is of: ConfigError where it is of another run.

        Results that `keeps` does not accept are run again next time.
        """
        self.path = path
        self._lock = Lock()
        self._known: dict[str, Finished] = {}
        path.parent.mkdir(parents=True, exist_ok=True)
        complete = path.read_text().rpartition("\n")[0] if path.exists() else ""  # the last line may be cut off
        lines = [json.loads(line) for line in complete.splitlines()]
        if run is not None and lines and lines[0] != {"run": run}:
            raise ConfigError(f"{path}: the journal of another run; remove it, or choose another output")
        for line in lines[run is not None :]:
            if not line["failure"] and keeps(line["result"]):
                self._known[line["key"]] = Finished(line["result"], seconds=line["seconds"], known=True)
        if run is not None and not lines:
            complete = json.dumps({"run": run})
        path.write_text(complete + "\n" if complete else "")

    def __len__(self) -> int:
        return len(self._known)

    def find(self, key: str) -> Finished | None:
        """A finished job."""
        return self._known.get(key)

    def add(self, key: str, finished: Finished) -> None:
        """Writes a job down."""
        line = {
            "key": key,
            "seconds": round(finished.seconds, 3),
            "failure": finished.failure,
            "result": finished.result,
        }
        with self._lock, self.path.open("a") as file:
            file.write(json.dumps(line) + "\n")


def run_jobs(
    jobs: Sequence[Job],
    workers: int,
    journal: Journal | None = None,
    *,
    memory: int | None = None,
    on_done: OnFinished = lambda *_: None,
) -> list[Finished]:
    """Runs the jobs that the journal lacks, and returns what came of all, in their order.

    Args:
        jobs: what to do.
        workers: processes at a time; 0 does it all in this process, where nothing holds a job back.
        journal: where each is written down as it finishes.
        memory: [bytes] that a job may use; as many as there are where left out.
        on_done: called as each one finishes, one call at a time.

    On KeyboardInterrupt the processes end, and what has finished is in the journal.
    """
    if workers == 0:
        return [_here(job, on_done) for job in jobs]
    idle: Queue[Worker] = Queue()
    everyone = [Worker(memory) for _ in range(workers)]
    for worker in everyone:
        idle.put(worker)
    stopping, telling = Event(), Lock()

    def one(job: Job) -> Finished:
        finished = journal.find(job.key) if journal is not None else None
        if finished is None:
            worker = idle.get()
            if stopping.is_set():
                return Finished({}, "interrupted")
            finished = worker.run(job)
            idle.put(worker)
            if stopping.is_set():
                return Finished({}, "interrupted")
            if journal is not None:
                journal.add(job.key, finished)
        with telling:
            try:
                on_done(job, finished)
            except BaseException:
                stopping.set()  # at once: this thread would begin the next job before the caller's ends them
                raise
        return finished

    threads = ThreadPoolExecutor(workers)
    try:
        return list(threads.map(one, jobs))
    finally:
        stopping.set()
        for worker in everyone:
            worker.stop()
            idle.put(worker)  # for those that wait for one
        threads.shutdown(cancel_futures=True)


def _here(job: Job, on_done: OnFinished) -> Finished:
    begun = time.monotonic()
    kind, value = _answer(job.function, job.arguments)
    seconds = time.monotonic() - begun
    finished = Finished(value, seconds=seconds) if kind == "result" else Finished({}, value, seconds=seconds)
    on_done(job, finished)
    return finished


class Worker:
    """A process that does jobs one after another, replaced when one kills it."""

    def __init__(self, memory: int | None) -> None:
        self._memory = memory
        self._process: Any = None
        self._connection: Connection | None = None
        self._stopped = False

    def run(self, job: Job) -> Finished:
        """One job; what it failed of if it raises, dies or hangs."""
        begun = time.monotonic()
        for _ in range(KILLED):
            finished, by_signal = self._try(job)
            if not by_signal or self._stopped:
                break
        return Finished(finished.result, finished.failure, finished.own, time.monotonic() - begun)

    def stop(self) -> None:
        """Ends the process."""
        self._stopped = True
        self._end()

    def _try(self, job: Job) -> tuple[Finished, bool]:
        """What came of it, and whether a signal ended the process."""
        connection = self._ready()
        try:
            connection.send((job.function, dict(job.arguments)))
            if not connection.poll(job.limit):
                self._end()
                return Finished({}, f"took longer than {job.limit:g} s", own=True), False
            kind, value = connection.recv()
        except (PicklingError, AttributeError, TypeError) as error:
            return Finished({}, f"the job cannot be sent: {error}"), False
        except (EOFError, OSError):
            code = self._end()
            how = f"by signal {-code}" if code < 0 else f"with status {code}"
            return Finished({}, f"its process died {how}", own=True), code < 0
        if kind == "result":
            return Finished(value), False
        return Finished({}, value, own=kind == "memory"), False

    def _ready(self) -> Connection:
        if self._process is None or self._connection is None:
            context = get_context("spawn")
            self._connection, other = context.Pipe()
            self._process = context.Process(
                target=_serve, args=(other, self._memory, str(Path.cwd()), sys.path), daemon=True
            )
            self._process.start()
            other.close()
        return self._connection

    def _end(self) -> int:
        """Kills the process, if it is there; how it ended."""
        process, self._process = self._process, None
        if process is None:
            return 0
        process.join(0.5 if self._connection is not None and not self._stopped else 0.0)
        if process.is_alive():
            process.kill()
        process.join()
        if self._connection is not None:
            self._connection.close()
        return int(process.exitcode)


def _serve(connection: Connection, memory: int | None, folder: str, path: list[str]) -> None:
    """What a worker's process does, until its parent is gone. It leaves Ctrl-C to the parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with_parent, daemon=True).start()
    os.chdir(folder)
    sys.path[:] = path
    _limit_memory(memory)
    while True:
        try:
            function, arguments = connection.recv()
        except EOFError:
            return
        connection.send(_answer(function, arguments))


def _end_with_parent() -> None:
    """A job that hangs would outlive a parent that was killed."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _limit_memory(memory: int | None) -> None:
    """What this process asks for beyond so many bytes is a MemoryError."""
    if memory is not None:
        resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))


def _answer(function: Callable[..., Result], arguments: Mapping[str, Any]) -> tuple[str, Any]:
    """Does a job: `result` and what came of it, or `raised` or `memory` and why nothing did."""
    try:
        result = function(**arguments)
        if not isinstance(result, dict):
            return "raised", f"it returned {type(result).__name__}, not a dict"
        json.dumps(result)
    except MemoryError:
        return "memory", "used too much memory"
    except Exception:
        return "raised", traceback.format_exc()
    return "result", result
