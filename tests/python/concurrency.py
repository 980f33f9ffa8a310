"""Programs that wait for robot time in every way, each of which writes down what happened when.

What they write must be the same in every run, on every Python version, on a busy machine and an idle one, in the fake
world and the real one: it is kept in `golden/concurrency.json`. To print it anew: `python tests/python/concurrency.py`.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import sys
import time
from collections.abc import Awaitable, Callable

from threewe._time import RobotTime
from threewe.errors import TimeoutError

Transcript = list[tuple[float, str]]


class Stage:
    """The worlds that a program uses, and the transcript that it writes."""

    def __init__(self, clocks: list[RobotTime]) -> None:
        self.clocks = clocks
        self.transcript: Transcript = []

    @property
    def clock(self) -> RobotTime:
        return self.clocks[0]

    def note(self, event: str, clock: RobotTime | None = None) -> None:
        self.transcript.append((round((clock or self.clock).now, 9), event))

    async def sleeper(self, name: str, *steps: float, clock: RobotTime | None = None, turns: int = 0) -> str:
        """Sleeps step by step; between two steps it gives up its turn `turns` times."""
        for number, step in enumerate(steps):
            await (clock or self.clock).sleep(step)
            for _ in range(turns):
                await asyncio.sleep(0)
            self.note(f"{name}{number}", clock)
        return name


Program = Callable[[Stage], Awaitable[None]]
PROGRAMS: dict[str, Program] = {}


def program(function: Program) -> Program:
    PROGRAMS[function.__name__] = function
    return function


@program
async def one_after_another(stage: Stage) -> None:
    for seconds in (0.02, 0.05, 0.0, 1.0, 0.001, 3.0):
        await stage.clock.sleep(seconds)
        stage.note(f"slept {seconds}")


@program
async def gather(stage: Stage) -> None:
    names = await asyncio.gather(
        stage.sleeper("a", 0.3, 0.3, 0.3),
        stage.sleeper("b", 0.1, 0.2, 0.3, 0.3, turns=5),
        stage.sleeper("c", 0.9, 0.1, turns=1),
    )
    stage.note("".join(names))


@program
async def ties_resume_by_deadline_then_creation(stage: Stage) -> None:
    # all end in the tick at 0.1 s
    steps = {"late": 0.1, "early": 0.09, "middle": 0.095, "second late": 0.1}
    await asyncio.gather(*(stage.sleeper(name, seconds) for name, seconds in steps.items()))


@program
async def task_group(stage: Stage) -> None:
    async with asyncio.TaskGroup() as group:
        for i in range(4):
            group.create_task(stage.sleeper(f"task{i} ", 0.1 * (4 - i), 0.1, turns=i))
        stage.note("all begun")
    stage.note("all done")


@program
async def nested(stage: Stage) -> None:
    async def level(depth: int, name: str) -> None:
        if depth == 0:
            await stage.clock.sleep(0.1)
        else:
            async with asyncio.TaskGroup() as group:
                group.create_task(level(depth - 1, name + "l"))
                group.create_task(stage.sleeper(f"{name} ", 0.1, 0.02 * depth, turns=depth))
            await asyncio.gather(level(0, name), asyncio.create_task(stage.sleeper(f"{name}' ", 0.04)))
        stage.note(f"{name} done")

    await level(12, "")


@program
async def a_failure_ends_its_group(stage: Stage) -> None:
    async def fail() -> None:
        await stage.clock.sleep(0.25)
        raise LookupError("on purpose")

    try:
        async with asyncio.TaskGroup() as group:
            group.create_task(stage.sleeper("a", 0.1, 0.1, 10.0))
            group.create_task(fail())
    except* LookupError:
        stage.note("failed")
    await stage.clock.sleep(0.1)
    stage.note("on")


@program
async def cancellation(stage: Stage) -> None:
    task = asyncio.create_task(stage.sleeper("a", 0.1, 10.0))
    await stage.clock.sleep(0.5)
    task.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await task
    stage.note("cancelled")
    await stage.clock.sleep(0.1)
    stage.note("the rest of the sleep is forgotten")


@program
async def timeout(stage: Stage) -> None:
    try:
        async with stage.clock.timeout(0.5):
            await stage.sleeper("a", 0.2, 0.2, 0.2)
    except TimeoutError as error:
        stage.note(str(error))
    async with stage.clock.timeout(0.5) as limit:
        await stage.sleeper("b", 0.2)
    stage.note(f"expired: {limit.expired}")
    await stage.clock.sleep(1.0)
    stage.note("no late cancellation")


@program
async def nested_timeouts(stage: Stage) -> None:
    for inner, outer in ((0.3, 0.5), (0.5, 0.3), (0.3, 0.3)):
        try:
            async with stage.clock.timeout(outer):
                try:
                    async with stage.clock.timeout(inner):
                        await stage.sleeper("a", 0.2, 10.0)
                except TimeoutError as error:
                    stage.note(f"inner: {error}")
                    await stage.clock.sleep(1.0)
        except TimeoutError as error:
            stage.note(f"outer: {error}")


@program
async def a_timeout_alone_does_not_make_time_run(stage: Stage) -> None:
    async with stage.clock.timeout(1.0):
        await asyncio.sleep(0.005)  # wall time, outside of `thinking`
        stage.note("still there")


@program
async def thinking(stage: Stage) -> None:
    async def think() -> None:
        for seconds in (0.3, 0.0, 0.15):
            async with stage.clock.thinking(seconds=seconds):
                stage.note("hm")
                await asyncio.get_running_loop().run_in_executor(None, time.sleep, 0.003)
            stage.note(f"thought for {seconds}")

    await asyncio.gather(think(), stage.sleeper("a", 0.1, 0.1, 0.1, 0.1, 0.1))


@program
async def thoughts_at_the_same_time(stage: Stage) -> None:
    async def think(name: str, wall: float, seconds: float) -> None:
        async with stage.clock.thinking(seconds=seconds):
            await asyncio.sleep(wall)
        stage.note(f"{name} thought")

    await asyncio.gather(think("long", 0.003, 0.5), think("short", 0.006, 0.1), stage.sleeper("a", 0.1, 0.3, 0.2))


@program
async def a_thought_that_fails(stage: Stage) -> None:
    try:
        async with stage.clock.thinking(seconds=0.5):
            raise LookupError("on purpose")
    except LookupError:
        stage.note("failed")
    await stage.sleeper("a", 0.1)


@program
async def asyncio_timeouts_cancel(stage: Stage) -> None:
    waiting = asyncio.create_task(asyncio.wait_for(stage.clock.sleep(1.0), 0.002))
    async with stage.clock.thinking(seconds=0.0):  # robot time stands still, so the wall clock wins
        results = await asyncio.gather(waiting, return_exceptions=True)
        stage.note(type(results[0]).__name__)
        with contextlib.suppress(asyncio.TimeoutError):
            async with asyncio.timeout(0.002):
                await asyncio.Event().wait()
        stage.note("asyncio.timeout")
    await stage.sleeper("a", 0.1)


@program
async def queues_events_and_locks(stage: Stage) -> None:
    queue: asyncio.Queue[int] = asyncio.Queue(1)
    lock, half = asyncio.Lock(), asyncio.Event()

    async def produce() -> None:
        for i in range(6):
            await stage.clock.sleep(0.1)
            await queue.put(i)
            stage.note(f"put {i}")
            if i == 3:
                half.set()

    async def consume(name: str, seconds: float) -> None:
        for _ in range(3):
            async with lock:
                item = await queue.get()
            await stage.clock.sleep(seconds)
            stage.note(f"{name} got {item}")

    async def watch() -> None:
        await half.wait()
        stage.note("half")

    await asyncio.gather(produce(), consume("a", 0.15), consume("b", 0.3), watch())


@program
async def callbacks(stage: Stage) -> None:
    loop = asyncio.get_running_loop()

    def chain(left: int) -> None:
        if left:
            loop.call_soon(chain, left - 1)
        else:
            stage.note("chain done")

    loop.call_soon(chain, 50)
    task = asyncio.create_task(stage.sleeper("a", 0.02))
    task.add_done_callback(lambda _: stage.note("a is done"))
    await stage.clock.sleep(0.02)
    stage.note("main")
    await asyncio.sleep(0)


@program
async def generators(stage: Stage) -> None:
    async def ticks(period: float, count: int):
        for i in range(count):
            yield i
            await stage.clock.sleep(period)

    async def read(name: str, period: float) -> None:
        async for i in ticks(period, 4):
            stage.note(f"{name}{i}")

    await asyncio.gather(read("a", 0.1), read("b", 0.16))


@program
async def as_completed(stage: Stage) -> None:
    for done in asyncio.as_completed([stage.sleeper(n, s) for n, s in (("a", 0.3), ("b", 0.1), ("c", 0.2))]):
        stage.note(f"completed {await done}")


@program
async def several_worlds(stage: Stage) -> None:
    a, b, c = stage.clocks
    await asyncio.gather(
        stage.sleeper("a", 0.1, 0.1, 0.1, clock=a),
        stage.sleeper("b", 0.06, 0.06, 0.06, 0.06, clock=b, turns=3),
        stage.sleeper("c", 0.2, clock=c),
    )
    stage.note(f"{a.now:.2f} {b.now:.2f} {c.now:.2f}")


@program
async def one_world_stands_still_while_another_goes_on(stage: Stage) -> None:
    a, b, _ = stage.clocks

    async def think() -> None:
        await a.sleep(0.1)
        async with a.thinking(seconds=0.2):
            await b.sleep(0.3)
            stage.note("b", b)
        stage.note("a thought", a)

    await asyncio.gather(think(), stage.sleeper("a", 0.1, 0.1, 0.1, clock=a))


@program
async def worlds_that_take_turns(stage: Stage) -> None:
    a, b, _ = stage.clocks

    async def relay(clock: RobotTime, other: RobotTime, name: str) -> None:
        for i in range(5):
            await clock.sleep(0.02 * (i + 1))
            await other.sleep(0.02)
            stage.note(f"{name}{i} {other.now:.2f}", clock)

    await asyncio.gather(relay(a, b, "ab"), relay(b, a, "ba"))


@program
async def eager_tasks(stage: Stage) -> None:
    if sys.version_info < (3, 12):
        return
    loop = asyncio.get_running_loop()
    loop.set_task_factory(asyncio.eager_task_factory)
    try:
        async with asyncio.TaskGroup() as group:
            for i in range(3):
                group.create_task(stage.sleeper(f"eager{i} ", 0.0, 0.1, 0.02 * i, turns=i))
            stage.note("all begun")
    finally:
        loop.set_task_factory(None)


async def perform(name: str, clocks: list[RobotTime]) -> Transcript:
    """The transcript of one program on worlds at time 0."""
    stage = Stage(clocks)
    for clock in clocks:
        clock.start()
    try:
        await PROGRAMS[name](stage)
    finally:
        for clock in clocks:
            clock.stop()
    return stage.transcript


def main() -> None:
    from fake_world import FakeWorld

    golden = {name: asyncio.run(perform(name, [RobotTime(FakeWorld()) for _ in range(3)])) for name in PROGRAMS}
    lines = [f"  {json.dumps(name)}: {json.dumps(transcript)}" for name, transcript in golden.items()]
    print("{", ",\n".join(lines), "}", sep="\n")


if __name__ == "__main__":
    main()
