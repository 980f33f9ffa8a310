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
from typing import Any

import numpy as np
from threewe import Robot
from threewe.data import Recording, TrajectoryRecorder, recover

from verify.cases.trees import PROGRAMS
from verify.harness import Case


def trials(kind: str, *arguments: int) -> Case:
    """What `verify_recorder` finds wrong, and how many trials it made."""
    done = subprocess.run(
        [PROGRAMS / "verify_recorder", kind, *map(str, arguments)], capture_output=True, text=True, check=True
    )
    *wrong, last = done.stdout.splitlines()
    return {"wrong": wrong, "trials": int(last.split()[1])}


async def _drive(seed: int, seconds: float, folder: Path | None) -> dict[str, Any]:
    """A minute of driving in real time; thread CPU time of each tick [s], and what a recorder makes of it."""
    async with Robot(realtime=True, seed=seed) as robot:
        stamps: list[float] = []
        robot.observe(lambda _: stamps.append(time.thread_time()))
        recorder = None if folder is None else TrajectoryRecorder(robot, folder)
        await robot.sleep(0.5)
        if recorder is not None:
            recorder.start_episode("load")
        stamps.clear()
        begun, cpu, wall = robot.now, time.process_time(), time.monotonic()
        while robot.now - begun < seconds:
            robot.set_velocity(0.2, 0.0, 0.6, hold=1.0)
            await robot.sleep(0.5)
        load = (time.process_time() - cpu) / (time.monotonic() - wall)
        seen: dict[str, Any] = {"load": load, "ticks": len(stamps), "p99": float(np.percentile(np.diff(stamps), 99))}
        if recorder is not None:
            ended = time.monotonic()
            recorder.end_episode(success=True)
            seen["end_episode"] = time.monotonic() - ended
            recorder.close()
        return seen


def in_real_time(seed: int, seconds: float) -> Case:
    """The same drive without and with a recorder, on one core: 50 Hz state, 30 Hz 640x480 colour, 10 Hz lidar."""
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    with tempfile.TemporaryDirectory() as folder:
        without = asyncio.run(_drive(seed, seconds, None))
        recorded = asyncio.run(_drive(seed, seconds, Path(folder)))
        [episode] = Recording(folder)
        frames = len(episode.camera())
        return {
            **recorded,
            "added": recorded["p99"] - without["p99"],
            "dropped": recorded["ticks"] - len(episode.time),
            "frames_missing": round(30 * seconds) - frames,
            "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,  # [MiB]
        }


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
