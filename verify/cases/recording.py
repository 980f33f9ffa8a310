"""A robot that is recorded in real time on one core; and programs that are killed while they record."""

from __future__ import annotations

import asyncio
import os
import resource
import signal
import subprocess
import sys
import tempfile
import textwrap
import time
from pathlib import Path

import numpy as np
from threewe import Robot
from threewe.data import Recording, TrajectoryRecorder, recover

from verify.cases.trees import PROGRAMS
from verify.harness import Case

PIECE = 1.0
"""[s] of a drive that is recorded, or is not."""
PIECES = 5
"""In a block, of either kind: 250 ticks."""


def trials(kind: str, *arguments: int) -> Case:
    """What `verify_recorder` finds wrong, and how many trials it made."""
    done = subprocess.run(
        [PROGRAMS / "verify_recorder", kind, *map(str, arguments)], capture_output=True, text=True, check=True
    )
    *wrong, last = done.stdout.splitlines()
    return {"wrong": wrong, "trials": int(last.split()[1])}


async def _record(seed: int, seconds: float, folder: Path) -> Case:
    """A drive in real time that is recorded: what is in its journal, and what it takes of the core."""
    async with Robot(realtime=True, seed=seed) as robot:
        ticks: list[float] = []
        robot.observe(lambda _: ticks.append(robot.now))
        recorder = TrajectoryRecorder(robot, folder)
        await robot.sleep(0.5)
        recorder.start_episode("load")
        ticks.clear()
        cpu, wall = time.process_time(), time.monotonic()
        await _circle(robot, seconds)
        load = (time.process_time() - cpu) / (time.monotonic() - wall)
        ended = time.monotonic()
        recorder.end_episode(success=True)
        ended = time.monotonic() - ended
        recorder.close()
    [episode] = Recording(folder)
    return {
        "load": load,
        "dropped": len(ticks) - len(episode.time),
        "frames_missing": round(30 * seconds) - len(episode.camera()),
        "end_episode": ended,
        "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,  # [MiB]
    }


async def _circle(robot: Robot, seconds: float) -> None:
    end = robot.now + seconds
    while robot.now < end:
        robot.set_velocity(0.2, 0.0, 0.6, hold=1.0)
        await robot.sleep(min(0.5, end - robot.now))


async def _added(seed: int, seconds: float, folder: Path) -> float:
    """[s] that recording adds to the 99th percentile of a tick's thread CPU time.

    Of one drive, pieces in turn are recorded and are not: whatever else makes ticks longer, such as a map that grows or
    other programs, does so to both. Bursts of that are in few blocks of pieces, so that the median is without them.
    """
    added = []
    async with Robot(realtime=True, seed=seed) as robot:
        stamps: list[float] = []
        robot.observe(lambda _: stamps.append(time.thread_time()))
        with TrajectoryRecorder(robot, folder) as recorder:
            await robot.sleep(0.5)
            for _ in range(round(seconds / (PIECE * PIECES))):
                ticks: dict[bool, list[float]] = {False: [], True: []}
                for piece in range(2 * PIECES):
                    recorded = piece % 4 in (1, 2)
                    if recorded:
                        recorder.start_episode("load")
                    stamps.clear()
                    await _circle(robot, PIECE)
                    ticks[recorded] += np.diff(stamps).tolist()
                    if recorded:
                        recorder.discard_episode()
                added.append(np.percentile(ticks[True], 99) - np.percentile(ticks[False], 99))
    return float(np.median(added))


def in_real_time(seed: int, seconds: float) -> Case:
    """A drive that is recorded on one core: 50 Hz state, 30 Hz 640x480 colour, 10 Hz lidar."""
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    with tempfile.TemporaryDirectory() as folder:
        recorded = asyncio.run(_record(seed, seconds, Path(folder, "whole")))
        added = asyncio.run(_added(seed, seconds, Path(folder, "pieces")))
        return {**recorded, "added": added}


PROGRAM = textwrap.dedent("""
    import asyncio, sys
    from threewe import Robot
    from threewe.data import TrajectoryRecorder

    async def main():
        async with Robot(hardware="3we_depth_v2", image_size=(96, 128)) as robot:
            recorder = TrajectoryRecorder(robot, sys.argv[1])
            robot.observe(lambda tick: recorder.recording and print("tick", recorder.ticks, flush=True))
            for number in range(5):
                recorder.start_episode("trial")
                await robot.move_forward(0.4 if number % 2 else -0.4)
                recorder.end_episode(success=True)
                print("end", number, flush=True)
            print("done", flush=True)

    asyncio.run(main())
""")


def killed(seed: int) -> Case:
    """A Python program that records with video and depth, killed after a number of ticks that the seed draws."""
    after = seed % 700
    with tempfile.TemporaryDirectory() as folder:
        child = subprocess.Popen([sys.executable, "-c", PROGRAM, folder], stdout=subprocess.PIPE, text=True)
        assert child.stdout is not None
        lines: list[str] = []
        for line in child.stdout:
            lines.append(line)
            if len(lines) > after:
                os.kill(child.pid, signal.SIGKILL)
                break
        lines += child.stdout.read().splitlines()
        child.wait()
        words = [line.split() for line in lines if len(line.split()) == 2]
        finished = sum(word == "end" for word, _ in words)
        since = [int(number) for word, number in words[_last_end(words) + 1 :] if word == "tick"]
        recover(folder)
        whole = [episode for episode in Recording(folder) if not episode.recovered] if finished else []
        rest = [len(e.time) for e in Recording(folder) if e.recovered] if list(Path(folder).glob("*.journal")) else []
        lost = max([0, *since]) - max([0, *rest])
        for episode in whole:
            camera = episode.camera()
            camera.color(len(camera) - 1)
        return {"finished_lost": finished - len(whole), "ticks_lost": lost if len(whole) <= finished else 0}


def _last_end(words: list[list[str]]) -> int:
    """Where the last episode ended; -1 where none has."""
    return max((i for i, (word, _) in enumerate(words) if word == "end"), default=-1)
