"""Commands of `threewe benchmark`: sets are made and checked, bundles are verified, and progress has the time left."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from itertools import count
from pathlib import Path

import command_line
import pytest
from threewe.benchmark.attempt import Settings
from threewe.benchmark.bundle import write_bundle
from threewe.benchmark.episodes import digest, find_episodes
from threewe.benchmark.progress import progress
from threewe.benchmark.run import plan_run, results_of, run

from verify.cases.forgeries import Forger

THREEWE = str(Path(sys.executable).parent / "threewe")
SET = "vln_val_v1"  # which is drawn in seconds


def command(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return command_line.threewe("benchmark", *arguments, cwd=folder)


def program(folder: Path, *arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """The same in a process of its own."""
    variables = {**os.environ, **environment}
    words = [THREEWE, "benchmark", *arguments]
    return subprocess.run(words, cwd=folder, env=variables, capture_output=True, text=True, timeout=300)


def test_a_set_that_is_made_is_the_one_that_comes_with_3we(tmp_path: Path) -> None:
    made = command(tmp_path, "episodes", "make", SET)
    assert made.returncode == 0, made.stderr
    again = command(tmp_path, "episodes", "make", SET, "-o", "again.json")
    for name, done in {f"{SET}.json": made, "again.json": again}.items():
        assert (tmp_path / name).read_bytes() == find_episodes(SET).read_bytes()
        assert f"{name}: 200 episodes, sha256 {digest(tmp_path / name)}" in " ".join(done.stdout.split())


def test_a_set_is_checked_byte_by_byte(tmp_path: Path) -> None:
    genuine = find_episodes(SET).read_bytes()
    done = command(tmp_path, "episodes", "check", SET)
    assert (done.returncode, done.stdout) == (0, f"{SET}: as drawn, 200 episodes\n")
    lines = genuine.splitlines(keepends=True)
    seed = re.search(rb"\d{15,}", lines[30])
    assert seed
    changed = lines[30].replace(seed[0], b"%d" % (int(seed[0]) - 1))
    for content, line in [
        (b"".join([*lines[:30], changed, *lines[31:]]), 31),
        (genuine.replace(b"\n", b"\r\n"), 1),
        (b"".join(lines[:50]), 51),
    ]:
        (tmp_path / f"{SET}.json").write_bytes(content)
        done = command(tmp_path, "episodes", "check", f"{SET}.json")
        assert (done.returncode, done.stdout) == (1, f"{SET}: differs in line {line} from what is drawn\n")


@pytest.mark.parametrize("what", ["make", "check"])
def test_a_set_that_is_not_known_is_named(what: str, tmp_path: Path) -> None:
    done = command(tmp_path, "episodes", what, "vln_val_v2")
    assert done.returncode == 2
    assert f"did you mean '{SET}'" in done.stderr.replace("\n", " ")
    assert not list(tmp_path.iterdir())


@pytest.fixture(scope="module")
def genuine(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("genuine")
    scenes = ["apartment_v1"]
    plan, listed = plan_run("pointnav", "straight", split="val", scenes=scenes, episodes=1, settings=Settings())
    outcomes = run(plan, listed, folder / "journal.jsonl", workers=0)
    write_bundle(folder / "run.zip", results_of(plan, listed, outcomes), outcomes)
    return folder / "run.zip"


def test_a_genuine_bundle_is_verified_and_its_policy_rerun(genuine: Path, tmp_path: Path) -> None:
    done = command(tmp_path, "verify", str(genuine))
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("verified: 1 episodes replay to the bit, track open\n")
    rerun = [
        command(tmp_path, "verify", str(genuine), "--rerun-policy", "--seed", seed, "--new-episodes", "1")
        for seed in ("7", "7", "8")
    ]
    for seed, again in zip((7, 7, 8), rerun, strict=True):
        assert again.returncode == 0, again.stderr
        assert again.stdout.startswith(done.stdout)
        assert f"the same policy in 1 new buildings of seed {seed}:\n" in again.stdout
        assert f"pointnav_rerun_{seed}, mock" in again.stdout
    first, same, other = (again.stdout.removeprefix(done.stdout) for again in rerun)
    assert first == same
    assert first.replace("7", "8") != other.replace("7", "8"), "other buildings"
    assert list(tmp_path.iterdir()) == []


def test_a_forged_bundle_is_refused_with_the_reason(genuine: Path, tmp_path: Path) -> None:
    forger = Forger(genuine, 0)
    metrics = forger.results["episode_results"][0]["metrics"]
    metrics["spl"] += 0.25
    (tmp_path / "forged.zip").write_bytes(forger.packed())
    (tmp_path / "none.zip").write_bytes(b"PK, and nothing else")
    for name, options, reason in [
        ("forged.zip", [], rf"episode 0 \(apartment_v1/\d+\): spl is [\d.]+ by its replay, {metrics['spl']} by"),
        ("forged.zip", ["--rerun-policy", "--seed", "7"], ".*: spl is .* by its replay"),
        ("none.zip", [], "none.zip: no bundle: "),
    ]:
        done = command(tmp_path, "verify", name, *options)
        assert done.returncode == 1, done.stderr
        assert re.match(f"refused: {reason}", done.stdout.replace("\n", " ")), done.stdout
        assert "verified" not in done.stdout
        assert "new buildings" not in done.stdout, "nothing of a forged bundle is run"
        assert "Traceback" not in done.stderr
    done = command(tmp_path, "verify", "missing.zip")
    assert done.returncode == 2
    assert "missing.zip" in done.stderr


def test_a_policy_of_another_source_is_not_rerun(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(
        "class Waits:\n    async def run(self, robot, assignment): await robot.sleep(1.0)\n"
    )
    run = ("run", "pointnav", "--agent", "mine:Waits", "--scene", "apartment_v1", "--episodes", "1")
    assert program(tmp_path, *run, "--bundle", "run.zip").returncode == 0
    rerun = ("verify", "run.zip", "--rerun-policy", "--seed", "7", "--new-episodes", "1")
    assert "the same policy in 1 new buildings of seed 7" in program(tmp_path, *rerun).stdout
    with (tmp_path / "mine.py").open("a") as file:
        file.write("print('imported')\n")
    done = program(tmp_path, *rerun)
    assert done.returncode == 2
    assert done.stderr.endswith("error: agent: mine:Waits here is another than in the bundle, by its source\n")
    assert "imported" not in done.stdout
    assert "verified: 1 episodes" in done.stdout, "its log is as it was"
    assert "new buildings" not in done.stdout


def test_a_run_shows_how_far_it_is_and_the_time_left(tmp_path: Path) -> None:
    run = ("run", "pointnav", "--agent", "straight", "--scene", "apartment_v1", "--episodes", "3")
    done = program(tmp_path, *run, FORCE_COLOR="1", COLUMNS="120", TERM="xterm")
    assert done.returncode == 0, done.stderr
    shown = re.sub(r"\x1b\[[\d;?]*\w", "", done.stderr)
    assert re.search(r"pointnav, straight ━+ 3/3 0:\d\d:\d\d 0:00:00 left", shown)


def test_the_time_left_is_that_of_the_mean_rate(capsys: pytest.CaptureFixture[str]) -> None:
    def shown(*steps: dict[str, object], total: int | None = 100) -> str:
        """The last line of a bar that advances each minute."""
        minutes = count(0.0, 60.0)
        with progress("{drive}", total, clock=lambda: next(minutes)) as advance:
            for step in steps:
                advance(**step)
        return capsys.readouterr().err.strip().splitlines()[-1]

    assert "left" not in shown()
    assert shown().startswith("{drive} ")
    assert shown({}).endswith(" 1:39:00 left"), "from the first on, however long it takes"
    assert shown({}, {}, {}).endswith(" 1:37:00 left")
    assert shown(*[{}] * 100).endswith(" 0:00:00 left")
    assert "left" not in shown({"known": True}), "what a journal holds took no time"
    assert " 3/100 " in shown({"known": True}, {"known": True}, {})
    assert shown({"done": 10, "of": 40}, total=None).endswith(" 0:03:00 left")
    assert "left" not in shown({}, total=None)
