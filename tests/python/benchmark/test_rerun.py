"""A policy is run again by its source, and what it does when it is imported and made is limited as what it drives."""

from __future__ import annotations

import code
import hashlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from threewe import ConfigError
from threewe.benchmark import verifying
from threewe.benchmark.agents import Identity
from threewe.benchmark.attempt import Settings
from threewe.benchmark.bundle import BundleError
from threewe.benchmark.run import plan_run
from threewe.benchmark.verifying import Verified, rerun_policy

IMPORTED = """\
from pathlib import Path
with Path("imported.txt").open("a") as file:
    file.write(f"{__name__}\\n")
"""
AGENTS = """
import time
class Goes:
    async def run(self, robot, assignment):
        await robot.move_to(*assignment.goal)
class Hangs(Goes):
    def __init__(self):
        time.sleep(1000.0)
class EatsMemory(Goes):
    def __init__(self):
        self.weights = bytearray(6 << 30)
class Exits(Goes):
    def __init__(self):
        raise SystemExit(3)
class Boasts(Goes):
    privileged = True
"""


@pytest.fixture
def claimed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Verified]:
    """What a bundle of an agent in `crowd.stranger` claims, whose package says when it is imported."""
    monkeypatch.chdir(tmp_path)
    package = tmp_path / "crowd"
    package.mkdir()
    (package / "__init__.py").write_text(IMPORTED)
    (package / "stranger.py").write_text(IMPORTED + AGENTS)
    source = hashlib.sha256((package / "stranger.py").read_bytes()).hexdigest()
    plan, _ = plan_run("pointnav", "navigator", split="val", scenes=["apartment_v1"], episodes=1, settings=Settings())

    def claim(name: str, source: str = source) -> Verified:
        agent = Identity(name, "run", False, source)
        return Verified(replace(plan, agent=agent), {}, 0.0)

    return claim


def test_an_agent_of_that_source_is_run(claimed: Callable[..., Verified], tmp_path: Path) -> None:
    again = rerun_policy(claimed("crowd.stranger:Goes"), seed=3, episodes=1, workers=1, folder=tmp_path)
    assert again["summary"]["all"]["success"]["value"] == 1.0
    assert again["agent"]["name"] == "crowd.stranger:Goes"


@pytest.mark.parametrize("name", ["crowd.stranger:Goes", "crowd.stranger:Hangs", "code:interact"])
def test_nothing_of_another_source_is_imported(name: str, claimed: Callable[..., Verified], tmp_path: Path) -> None:
    with pytest.raises(BundleError, match="another than in the bundle, by its source"):
        rerun_policy(claimed(name, "0" * 64), seed=3, episodes=1, workers=1, folder=tmp_path)
    assert not (tmp_path / "imported.txt").exists()


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("crowd.stranger:Hangs", "took longer than 15 s"),
        ("crowd.stranger:EatsMemory", "MemoryError"),
        ("crowd.stranger:Exits", "its process died with status 3"),
        ("crowd.stranger:Boasts", "another than in the bundle: .*'privileged': True"),
        ("crowd.stranger:time", "expected a class that crowd.stranger defines"),
        ("crowd.stranger:None", "has no attribute 'None'"),
    ],
)
def test_what_it_does_when_it_is_made_costs_the_verifier_nothing(
    name: str, why: str, claimed: Callable[..., Verified], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(verifying, "EPISODE_LIMIT", 15.0)
    with pytest.raises(BundleError, match=why):
        rerun_policy(claimed(name), seed=3, episodes=1, workers=1, memory=2 << 30, folder=tmp_path)


@pytest.mark.parametrize("name", ["code:interact", "code:InteractiveConsole"])
def test_what_is_no_agent_is_never_called(name: str, claimed: Callable[..., Verified], tmp_path: Path) -> None:
    source = hashlib.sha256(Path(code.__file__).read_bytes()).hexdigest()
    with pytest.raises(BundleError, match=r"expected a (class that code defines|method `run)"):
        rerun_policy(claimed(name, source), seed=3, episodes=1, workers=1, folder=tmp_path)


@pytest.mark.parametrize("name", ["sys:exit", "no.such.module:Agent", "..up:Agent", "none.onnx"])
def test_what_is_read_from_no_file_is_refused(name: str, claimed: Callable[..., Verified], tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="no such file"):
        rerun_policy(claimed(name), seed=3, episodes=1, workers=1, folder=tmp_path)
