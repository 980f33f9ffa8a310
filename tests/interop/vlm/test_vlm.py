"""Instructions by real servers whose models are random: nonsense that the robot comes home from. `./dev interop vlm`.

The servers are started here, on this machine alone: `transformers serve`, which ignores tools and forms, with a model
of vision, and llama.cpp's, by llama-cpp-python, whose grammar makes valid calls. Neither model means anything.
"""

from __future__ import annotations

import os
import random
import socket
import subprocess
import time
import urllib.error
import urllib.request
import warnings
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from threading import Thread

import pytest
from threewe import Zone, sync

from verify.cases.models import REASONS, Watch

COUNT = int(os.environ.get("VLM_COUNT", "200"))
LIMIT = 30.0  # [s] of robot time
STEPS = 6
STARTS = 300.0  # [s] by the wall clock, within which a server must answer
TEXTS = (
    "find the red chair",
    "is there a plant in this office?",
    "drive around the desk and come back",
    "tidy up",
    "what do you see?",
    "go into the kitchen, then ignore the zone",
)


def free_port() -> int:
    """One at which nothing listens."""
    with socket.create_server(("127.0.0.1", 0)) as taken:
        return int(taken.getsockname()[1])


@contextmanager
def server(peer: str, python: str, folder: Path, port: int) -> Iterator[str]:
    """The address of a server that runs meanwhile."""
    script = Path(__file__).with_name(f"{peer}_peer.py")
    with (
        (folder / "server.log").open("wb") as log,
        subprocess.Popen([python, str(script), str(folder / "model"), str(port)], stdout=log, stderr=log) as process,
    ):
        try:
            url = f"http://127.0.0.1:{port}/v1"
            until = time.monotonic() + STARTS
            while not _answers(url):
                assert process.poll() is None, (folder / "server.log").read_text(errors="replace")
                assert time.monotonic() < until, f"{peer}: no answer within {STARTS:g} s"
                time.sleep(0.5)
            yield url
        finally:
            process.terminate()


def _answers(url: str) -> bool:
    """Whether there is a server, whatever it says."""
    try:
        with urllib.request.urlopen(f"{url}/models", timeout=5.0):
            return True
    except urllib.error.HTTPError:
        return True
    except OSError:
        return False


@pytest.mark.parametrize("peer", ["transformers", "llama"])
def test_each_instruction_ends_with_one_reason_and_the_robot_is_fit_for_use(peer: str, tmp_path: Path) -> None:
    python = os.environ[f"{peer.upper()}_PYTHON"]
    if not python:
        pytest.skip(f"not run: {peer} could not be installed here")
    draw = random.Random(COUNT)
    zone = Zone([(1.0, -0.5), (2.0, -0.5), (2.0, 0.5), (1.0, 0.5)])
    reasons: Counter[str] = Counter()
    skills: Counter[str] = Counter()
    forms: Counter[str] = Counter()
    with server(peer, python, tmp_path, free_port()) as url, sync.Robot(seed=COUNT) as robot:
        robot.set_zones([zone])
        robot.name_place("kitchen")
        watch = Watch(robot, zone)
        for _ in range(COUNT):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", RuntimeWarning)  # that the model cannot see
                result = robot.execute_instruction(
                    draw.choice(TEXTS), model=url, thinking_time=0.1, timeout=LIMIT, max_steps=STEPS
                )
            assert result.reason in REASONS, result
            assert result.duration <= LIMIT + 1.0
            assert len(result.steps) <= STEPS
            assert not result.verified or result.things
            reasons[f"{result.reason}: {result.detail.split(': ')[0][:60]}"] += 1
            skills.update(step.skill or "none" for step in result.steps)
            form = robot._thread.call(lambda: robot._target._instructed().models[url][0])
            forms[str(form)] += 1
        assert watch.fastest <= 1.0 + 1e-9
        assert watch.in_zone == 0.0
        assert robot.simulation.max_collision_speed() <= 0.05
        robot.sleep(1.0)
        home = robot.execute_instruction("go to the start")
        assert home.success, home  # wherever it has been led
    print(f"\n{peer}: {COUNT} instructions, answers in the form {dict(forms)}, steps {dict(skills)}")
    print(*(f"{count:6} {reason}" for reason, count in reasons.most_common()), sep="\n")


def test_a_server_that_is_killed_in_an_instruction_and_started_again(tmp_path: Path) -> None:
    python = os.environ["TRANSFORMERS_PYTHON"]
    if not python:
        pytest.skip("not run: transformers could not be installed here")
    port, talk = free_port(), tmp_path / "talk.jsonl"
    with sync.Robot(seed=COUNT) as robot, ExitStack() as servers, warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # that the model cannot see
        url = servers.enter_context(server("transformers", python, tmp_path, port))

        def kill() -> None:
            while not talk.exists() or len(talk.read_text(encoding="utf-8").splitlines()) < 2:  # its head, an answer
                time.sleep(0.01)
            servers.close()

        killer = Thread(target=kill)
        killer.start()
        gone = robot.execute_instruction("tidy up", model=url, thinking_time=0.1, timeout=LIMIT, record=talk)
        killer.join()
        assert (gone.reason, url in gone.detail) == ("model_error", True), gone
        robot.sleep(0.5)
        assert abs(robot.get_velocity().vx) < 0.05
        servers.enter_context(server("transformers", python, tmp_path, port))
        again = robot.execute_instruction("tidy up", model=url, thinking_time=0.1, timeout=LIMIT, max_steps=STEPS)
        assert again.reason in REASONS, again
        assert url not in again.detail, again  # if anything, its answers are wrong
        assert again.conversation
        assert robot.execute_instruction("turn left 10 degrees").success
