"""The pump, on a world with nothing in it but time."""

from __future__ import annotations

import asyncio
import logging
import os
import random
import signal
import threading
import weakref
from collections.abc import Callable, Coroutine
from typing import Any

import pytest
from concurrency import PROGRAMS, perform
from fake_world import PERIOD, FakeWorld
from threewe._pump import Pump, pump_of_running_loop
from threewe._time import RobotTime
from threewe.errors import ConnectionError, ContractError, TimeoutError

Body = Callable[[RobotTime, FakeWorld], Coroutine[Any, Any, Any]]


def run(body: Body, world: FakeWorld | None = None) -> Any:
    """Runs `body` with a world that has been started."""
    world = world or FakeWorld()

    async def main() -> Any:
        clock = RobotTime(world)
        clock.start()
        try:
            return await body(clock, world)
        finally:
            clock.stop()

    return asyncio.run(main())


def test_time_stands_still_unless_somebody_waits() -> None:
    async def body(clock: RobotTime, world: FakeWorld) -> None:
        await asyncio.sleep(0.01)
        assert world.ticks == 0
        await clock.sleep(1.0)
        assert world.ticks == 50
        await asyncio.sleep(0.01)
        assert world.ticks == 50

    run(body)


def test_a_tick_starts_only_when_nothing_is_ready() -> None:
    """However many turns a task takes between two waits, robot time stands still meanwhile."""

    async def body(clock: RobotTime, world: FakeWorld) -> None:
        other = asyncio.create_task(clock.sleep(10.0))
        for turns in (1, 2, 10, 500):
            await clock.sleep(0.02)
            before = world.ticks
            for _ in range(turns):
                await asyncio.sleep(0)
            assert world.ticks == before
        other.cancel()

    run(body)


def test_callbacks_and_signals_have_their_turn_during_a_long_wait() -> None:
    async def body(clock: RobotTime, world: FakeWorld) -> None:
        called = asyncio.Event()
        asyncio.get_running_loop().call_later(0.02, called.set)
        waiting = asyncio.create_task(clock.sleep(1e8))
        await called.wait()
        assert world.ticks > 0
        waiting.cancel()

    run(body)


def test_ctrl_c_ends_a_long_wait() -> None:
    cleaned_up = []

    async def body(clock: RobotTime, world: FakeWorld) -> None:
        threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGINT)).start()
        try:
            await clock.sleep(1e8)
        finally:
            cleaned_up.append(world.has_pending())

    with pytest.raises(KeyboardInterrupt):
        run(body)
    assert cleaned_up == [False]


def test_a_spinning_task_is_reported_once(caplog: pytest.LogCaptureFixture) -> None:
    async def body(clock: RobotTime, _world: FakeWorld) -> None:
        async def spin() -> None:
            for _ in range(3000):
                await asyncio.sleep(0)

        spinning = asyncio.create_task(spin(), name="the spinner")
        innocent = asyncio.create_task(asyncio.Event().wait(), name="innocent")
        await clock.sleep(0.02)
        await spinning
        innocent.cancel()

    with caplog.at_level(logging.WARNING, "threewe"):
        run(body)
    [message] = caplog.messages
    assert "asyncio.sleep(0) in the spinner;" in message
    assert "robot.sleep" in message


def test_999_turns_are_not_reported(caplog: pytest.LogCaptureFixture) -> None:
    async def body(clock: RobotTime, _world: FakeWorld) -> None:
        for _ in range(3):
            other = asyncio.create_task(clock.sleep(0.02))
            for _ in range(998):
                await asyncio.sleep(0)
            await other

    run(body)
    assert not caplog.messages


def test_other_loops_get_a_hundred_turns_and_one_warning(caplog: pytest.LogCaptureFixture) -> None:
    async def main() -> None:
        worlds = [FakeWorld(), FakeWorld()]
        pump = Pump(asyncio.get_running_loop(), None)
        for world in worlds:
            pump.attach(world)

        async def sleep_then_compute(world: FakeWorld) -> None:
            await pump.wait(world, world.sleep(0.1))
            for _ in range(90):
                await asyncio.sleep(0)
            assert world.now == 0.1

        await asyncio.gather(*(sleep_then_compute(world) for world in worlds))

    asyncio.run(main())
    [message] = caplog.messages
    assert "may differ from run to run" in message


def test_uvloop_works_where_it_is_installed(caplog: pytest.LogCaptureFixture) -> None:
    uvloop = pytest.importorskip("uvloop", reason="not shown: uvloop is not installed")

    async def main() -> list[tuple[float, str]]:
        return await perform("thinking", [RobotTime(FakeWorld())])

    with asyncio.Runner(loop_factory=uvloop.new_event_loop) as runner:
        assert runner.run(main())[-1][1] == "a4"
    assert len(caplog.messages) == 1


def test_a_world_that_breaks_down_tells_all_who_wait_for_it(caplog: pytest.LogCaptureFixture) -> None:
    async def body(clock: RobotTime, _world: FakeWorld) -> None:
        healthy = RobotTime(FakeWorld())
        healthy.start()
        results = await asyncio.gather(clock.sleep(1.0), clock.sleep(2.0), healthy.sleep(3.0), return_exceptions=True)
        assert [type(result) for result in results] == [OSError, OSError, type(None)]
        with pytest.raises(ConnectionError):
            await clock.sleep(0.1)
        healthy.stop()

    run(body, FakeWorld(breaks_at=0.5))
    assert "the fake world broke down" in caplog.text


def test_disconnecting_ends_waits() -> None:
    async def body(clock: RobotTime, _world: FakeWorld) -> None:
        waiting = asyncio.create_task(clock.sleep(1e8))
        await clock.sleep(0.1)
        clock.stop()
        with pytest.raises(ConnectionError, match="disconnected"):
            await waiting
        with pytest.raises(ConnectionError, match="not connected"):
            await clock.sleep(0.1)

    run(body)


def test_waiting_inside_one_s_own_thinking_block_is_refused() -> None:
    async def body(clock: RobotTime, world: FakeWorld) -> None:
        with pytest.raises(ContractError, match="after the block"):
            async with clock.thinking(seconds=1.0):
                await clock.sleep(0.1)
        assert not world.held
        await clock.sleep(0.1)
        assert world.now == 0.1

    run(body)


def test_waiting_in_a_task_that_was_made_inside_a_thinking_block_is_refused() -> None:
    """Else the block waits for the task, and the task for the end of the block: for ever, and in silence."""

    async def body(clock: RobotTime, world: FakeWorld) -> None:
        async def think_in_a_group(deeper: Callable[[], Coroutine[Any, Any, None]]) -> None:
            async with clock.thinking(seconds=1.0), asyncio.TaskGroup() as group:
                group.create_task(deeper())

        async def nested() -> None:
            await asyncio.gather(asyncio.create_task(clock.sleep(0.1)))

        async def drive() -> None:
            await clock.wait_for_motion(world.motion(1.0))

        async def think_twice() -> None:
            async with clock.thinking(seconds=0.1):
                pass

        for deeper in (lambda: clock.sleep(0.1), nested, drive, think_twice):
            with pytest.RaisesGroup(pytest.RaisesExc(ContractError, match="made before it")):
                await think_in_a_group(deeper)
            assert not world.held
            assert not world.has_pending()
        assert world.now == 0.0
        await clock.sleep(0.1)

    run(body)


def test_tasks_made_inside_a_thinking_block_may_wait_after_it_and_others_at_all_times() -> None:
    async def body(clock: RobotTime, world: FakeWorld) -> None:
        other = RobotTime(FakeWorld())
        other.start()
        over = asyncio.Event()

        async def wait_then_sleep() -> None:
            await over.wait()
            await clock.sleep(0.5)

        before = asyncio.create_task(clock.sleep(0.3))
        async with clock.thinking(seconds=0.2):
            inside = asyncio.create_task(wait_then_sleep())
            await asyncio.create_task(other.sleep(1.0))  # another world's time
            assert not before.done()
        over.set()
        await asyncio.gather(before, inside)
        assert world.now == pytest.approx(0.7)
        assert other.now == 1.0
        other.stop()

    run(body)


@pytest.mark.parametrize("seconds", [-1.0, float("nan"), float("inf")])
def test_thinking_for_impossible_times(seconds: float) -> None:
    with pytest.raises(ContractError, match="seconds"):
        RobotTime(FakeWorld()).thinking(seconds=seconds)


def test_thinking_without_seconds_charges_the_wall_clock() -> None:
    async def body(clock: RobotTime, world: FakeWorld) -> None:
        async with clock.thinking():
            await asyncio.sleep(0.05)
        assert world.now >= 0.05

    run(body)


def test_a_cancelled_wait_is_forgotten() -> None:
    async def body(clock: RobotTime, world: FakeWorld) -> None:
        waiting = asyncio.create_task(clock.sleep(1e8))
        await clock.sleep(0.1)
        waiting.cancel()
        await asyncio.sleep(0)
        assert not world.has_pending()

    run(body)


def test_cancelling_a_task_cancels_its_motion() -> None:
    async def body(clock: RobotTime, world: FakeWorld) -> None:
        motion = world.motion(100.0)
        moving = asyncio.create_task(clock.wait_for_motion(motion))
        await clock.sleep(1.0)
        moving.cancel()
        await asyncio.gather(moving, return_exceptions=True)
        assert motion.cancelled
        assert motion.deadline == 1.0

    run(body)


def test_a_time_limit_cancels_a_motion() -> None:
    async def body(clock: RobotTime, world: FakeWorld) -> None:
        motion = world.motion(100.0)
        with pytest.raises(TimeoutError):
            async with clock.timeout(1.0):
                await clock.wait_for_motion(motion)
        assert motion.cancelled
        assert motion.deadline == 1.0

    run(body)


def test_a_motion_that_somebody_else_ends() -> None:
    """Its waiter hears of it even when nobody waits for robot time any more."""

    async def body(clock: RobotTime, world: FakeWorld) -> None:
        motion = world.motion(100.0)
        moving = asyncio.create_task(clock.wait_for_motion(motion))
        await clock.sleep(1.0)
        motion.cancel()
        clock.wake()
        await moving
        assert world.now == 1.0

    run(body)


def test_progress_is_told_every_tenth_of_a_second() -> None:
    async def body(clock: RobotTime, world: FakeWorld) -> None:
        heard: list[float] = []
        await clock.wait_for_motion(world.motion(0.5), lambda _progress: heard.append(clock.now))
        assert [round(now, 3) for now in heard] == [0.1, 0.2, 0.3, 0.4, 0.5]

    run(body)


def test_what_on_progress_raises_ends_the_motion() -> None:
    async def body(clock: RobotTime, world: FakeWorld) -> None:
        motion = world.motion(100.0)

        def fail(_progress: object) -> None:
            raise LookupError("on purpose")

        with pytest.raises(LookupError):
            await clock.wait_for_motion(motion, fail)
        assert motion.cancelled
        assert not world.has_pending()

    run(body)


def test_use_from_another_thread_is_refused() -> None:
    async def body(clock: RobotTime, _world: FakeWorld) -> None:
        with pytest.raises(ContractError, match="thread"):
            await asyncio.to_thread(clock.check_thread)

    run(body)


def test_a_world_belongs_to_one_loop_at_a_time() -> None:
    clock = RobotTime(FakeWorld())

    async def start_and_sleep() -> None:
        clock.start()
        await clock.sleep(1.0)

    async def elsewhere() -> None:
        def run_there() -> None:
            asyncio.run(start_and_sleep())

        with pytest.raises(ConnectionError, match="another event loop"):
            await asyncio.to_thread(run_there)

    async def main() -> None:
        await start_and_sleep()
        await elsewhere()

    asyncio.run(main())
    asyncio.run(start_and_sleep())  # that loop is closed, so it is free again
    assert clock.now == 2.0
    clock.stop()


def test_a_loop_that_is_closed_in_the_middle_of_a_wait() -> None:
    world = FakeWorld()
    clock = RobotTime(world)
    loop = asyncio.new_event_loop()

    async def start() -> asyncio.Task[None]:
        clock.start()
        return asyncio.create_task(clock.sleep(1e8))

    waiting = loop.run_until_complete(start())
    loop.run_until_complete(asyncio.sleep(0.001))
    waiting.cancel()
    loop.run_until_complete(asyncio.gather(waiting, return_exceptions=True))
    loop.close()
    asyncio.run(asyncio.wait_for(_start_and_sleep(clock), None))
    clock.stop()


async def _start_and_sleep(clock: RobotTime) -> None:
    clock.start()
    await clock.sleep(1.0)


def test_loops_in_several_threads_do_not_disturb_each_other() -> None:
    transcripts: dict[int, object] = {}

    def work(number: int) -> None:
        clocks = [RobotTime(FakeWorld()) for _ in range(3)]
        transcripts[number] = asyncio.run(perform("nested", clocks))

    threads = [threading.Thread(target=work, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(transcripts) == 8
    assert all(transcript == transcripts[0] for transcript in transcripts.values())


def test_closed_loops_are_forgotten() -> None:
    import threewe._pump

    for _ in range(5):
        run(lambda clock, _world: clock.sleep(0.1))
    closed = [loop for loop in threewe._pump._pumps if loop.is_closed()]  # loops of other tests may be running
    assert len(closed) == 1


class RealtimeWorld(FakeWorld):
    """Time goes by on its own, a tick whenever `due` says so."""

    realtime = True

    def __init__(self) -> None:
        super().__init__()
        self._late = random.Random(1)

    def due(self) -> float:
        return self._late.choice([0.0, 0.0, 0.001])


def test_real_time_goes_by_without_anybody_waiting() -> None:
    async def body(clock: RobotTime, world: FakeWorld) -> None:
        while world.ticks < 10:
            await asyncio.sleep(0)  # and whatever the loop is busy with
        before = world.time
        await clock.sleep(0.1)
        assert world.time >= before + 5 * PERIOD
        clock.stop()
        stopped = world.ticks
        await asyncio.sleep(0.01)
        assert world.ticks == stopped

    run(body, RealtimeWorld())


def test_the_pump_is_shared_by_all_worlds_of_a_loop() -> None:
    async def main() -> None:
        assert pump_of_running_loop() is pump_of_running_loop()

    asyncio.run(main())


def test_every_program_is_performed_by_the_concurrency_tests() -> None:
    assert len(PROGRAMS) > 20


@pytest.mark.parametrize("make", [FakeWorld, RealtimeWorld])
def test_a_world_that_is_dropped_is_stopped_and_let_go(make: Callable[[], FakeWorld]) -> None:
    async def main() -> None:
        world = make()
        clock = RobotTime(world)
        clock.start()
        await clock.sleep(0.1)
        gone = weakref.ref(clock)
        with pytest.warns(ResourceWarning, match="use `async with Robot"):
            del clock
        assert gone() is None
        await asyncio.sleep(0.01)
        assert world.disconnected
        stopped = world.ticks
        await asyncio.sleep(0.01)
        assert world.ticks == stopped
        kept = weakref.ref(world)
        del world
        assert kept() is None

    asyncio.run(main())


def test_a_world_that_is_dropped_after_its_loop_was_closed() -> None:
    world = FakeWorld()
    clock = RobotTime(world)
    asyncio.run(_start_and_sleep(clock))
    with pytest.warns(ResourceWarning, match="dropped while it was connected"):
        del clock
    assert world.disconnected
    kept = weakref.ref(world)
    del world
    assert kept() is None


def test_a_world_that_is_dropped_on_another_thread_is_stopped_on_its_own() -> None:
    class Picky(FakeWorld):
        def disconnect(self) -> None:
            super().disconnect()
            threads.append(threading.get_ident())

    threads: list[int] = []

    async def main() -> None:
        clocks = [RobotTime(Picky())]
        clocks[0].start()
        with pytest.warns(ResourceWarning):
            await asyncio.to_thread(clocks.clear)
        await asyncio.sleep(0.01)

    asyncio.run(main())
    assert threads == [threading.get_ident()]
