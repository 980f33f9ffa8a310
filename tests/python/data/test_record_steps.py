"""Learning environments that are recorded, and what LeRobot's format makes of them."""

import re
import resource
import signal
import subprocess
import sys
from pathlib import Path

import gymnasium
import numpy as np
import pytest
import threewe  # noqa: F401 (registers the environments)
from threewe.data.cli import app
from threewe.data.gym import RecordSteps, export_steps, recover_steps
from threewe.data.lerobot import Dataset, validate
from threewe.data.step_files import StepFile
from threewe.errors import ConfigError, ContractError, RecordingError
from typer.testing import CliRunner


def test_every_step_of_an_environment_is_in_the_dataset(tmp_path: Path) -> None:
    env = RecordSteps(gymnasium.make("3we/Navigation-v1", max_episode_steps=12), tmp_path / "steps", task="go")
    rng = np.random.default_rng(3)
    episodes: list[list[tuple[dict[str, np.ndarray], np.ndarray, float]]] = []
    for seed in range(3):
        observation, _ = env.reset(seed=seed)
        episodes.append([])
        while True:
            action = rng.uniform(-1, 1, 3).astype(np.float32)
            after, reward, terminated, truncated, _ = env.step(action)
            kept = {name: np.array(value) for name, value in observation.items()}
            episodes[-1].append((kept, action, float(reward)))
            observation = after
            if terminated or truncated:
                break
    env.close()
    export_steps(tmp_path / "steps", tmp_path / "dataset", fps=10)
    assert validate(tmp_path / "dataset") == []
    dataset = Dataset.open(tmp_path / "dataset")
    assert [len(episode) for episode in dataset.episodes] == [len(steps) for steps in episodes]
    for episode, steps in zip(dataset.episodes, episodes, strict=True):
        assert episode.tasks == ["go"]
        columns = episode.columns()
        assert np.array_equal(columns["action"], [action for _, action, _ in steps])
        assert columns["next.reward"].ravel() == pytest.approx([reward for _, _, reward in steps])
        assert columns["next.done"].ravel().tolist() == [False] * (len(steps) - 1) + [True]
        assert {f"observation.{name}" for name in steps[0][0]} <= columns.keys() | set(episode.cameras())
        for name in steps[0][0]:
            seen = np.array([observation[name] for observation, _, _ in steps])
            if f"observation.{name}" in columns:
                assert np.allclose(columns[f"observation.{name}"].reshape(seen.shape), seen)
            else:
                video = episode.video(f"observation.{name}")
                shown = np.array([video.image(i) for i in range(len(steps))])
                assert np.abs(shown[..., ::-1].astype(int) - seen).mean() < 8.0, "lossy, and RGB"


def test_what_reset_cuts_short_is_kept_and_a_folder_goes_on(tmp_path: Path) -> None:
    for _ in range(2):
        env = RecordSteps(gymnasium.make("CartPole-v1"), tmp_path)
        env.reset(seed=1)
        env.step(0)
        env.reset(seed=2)
        env.step(1)
        env.close()
    assert [file.name for file in sorted(tmp_path.iterdir())] == [f"episode_{i:06d}.npz" for i in range(4)]
    export_steps(tmp_path, tmp_path / "dataset", fps=50)
    assert len(Dataset.open(tmp_path / "dataset").episodes) == 4


PROGRAM = """
import sys
import gymnasium, numpy as np
from threewe.data.gym import RecordSteps

class Counter(gymnasium.Env):
    observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (1,), np.float64)
    action_space = gymnasium.spaces.Discrete(1000000)
    def reset(self, *, seed=None, options=None):
        self.count = 0
        return np.zeros(1), {}
    def step(self, action):
        self.count += 1
        return np.array([float(self.count)]), 0.0, False, False, {}

env = RecordSteps(Counter(), sys.argv[1], task="count")
for steps in (7, 10**9):
    env.reset()
    for step in range(steps):
        env.step(step)
        print(step, flush=True)
"""


@pytest.mark.parametrize("after", [0, 3, 8, 40, 190, 733])
def test_a_killed_program_loses_fifty_steps_at_most_and_no_finished_episode(tmp_path: Path, after: int) -> None:
    with subprocess.Popen([sys.executable, "-c", PROGRAM, str(tmp_path)], stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        lines = [child.stdout.readline() for _ in range(after)]
        child.kill()
        lines += child.stdout.readlines()
    done = [int(line) for line in lines if line.endswith("\n")]
    finished, current = (7, len(done) - 7) if len(done) > 7 else (0, len(done))
    found = {one.file.name: one.steps for one in recover_steps(tmp_path) if one.file}
    assert not list(tmp_path.glob("*.steps"))
    if finished:
        assert np.load(tmp_path / "episode_000000.npz")["action"].tolist() == list(range(7))
        assert found.get("episode_000001.npz", 0) >= current - 50
    else:
        assert found.get("episode_000000.npz", 7) >= current - 50
    for name, steps in found.items():
        episode = np.load(tmp_path / name)
        assert episode["task"] == "count"
        assert episode["action"].tolist() == list(range(steps))
        assert episode["observation.state"].ravel().tolist() == list(range(steps))


def test_what_is_cut_anywhere_or_changed_is_recovered_up_to_there(tmp_path: Path) -> None:
    file = StepFile(tmp_path, "go")
    for step in range(150):
        file.add({"action": step})
    (path,) = tmp_path.iterdir()
    assert recover_steps(tmp_path) == [], "it is being recorded"
    whole = path.read_bytes()
    file.close()
    rng = np.random.default_rng(0)
    counts = set()
    for _ in range(60):
        cut = int(rng.integers(len(whole) + 1))
        spoilt = bytearray(whole[:cut] if rng.random() < 0.5 else whole[:cut] + bytes(16))
        path.write_bytes(spoilt)
        [(made, steps)] = recover_steps(tmp_path)
        counts.add(steps)
        if made is not None:
            assert np.load(made)["action"].tolist() == list(range(steps))
    assert 0 in counts
    assert len(counts) > 2


def test_the_command_recovers_steps(tmp_path: Path) -> None:
    file = StepFile(tmp_path, "go")
    for step in range(60):
        file.add({"action": step, "observation.state": np.zeros(1), "next.done": False})
    file.close()
    done = CliRunner().invoke(app, ["recover", str(tmp_path)])
    assert done.exit_code == 0
    saved = re.fullmatch(r"episode_000000.npz: (\d+) steps saved\n", done.output)
    assert saved is not None
    export_steps(tmp_path, tmp_path / "dataset", fps=10)
    assert Dataset.open(tmp_path / "dataset").info.total_frames == int(saved[1]) >= 50
    assert CliRunner().invoke(app, ["recover", str(tmp_path)]).output == "nothing was cut off\n"


def test_programs_may_record_into_one_folder_at_once(tmp_path: Path) -> None:
    files = [StepFile(tmp_path, "go") for _ in range(3)]
    for file in files:
        file.add({"action": 1})
    assert sorted(file.finish().name for file in files) == [f"episode_{i:06d}.npz" for i in range(3)]


def test_a_disk_that_fails_is_an_error_and_spoils_nothing(tmp_path: Path) -> None:
    file = StepFile(tmp_path, "go")
    for step in range(49):
        file.add({"action": step})

    def add_many() -> None:
        for _ in range(50):
            file.add({"action": 49})

    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    signals = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (200, hard))
    try:
        with pytest.raises(RecordingError, match=r"cannot write .*episode_000000.steps"):
            add_many()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, signals)
    assert np.load(file.finish())["action"].tolist()[:50] == list(range(50))


def test_what_is_no_episode_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="there are no finished episodes"):
        export_steps(tmp_path, tmp_path / "dataset", fps=10)
    (tmp_path / "episode_000000.npz").write_bytes(b"junk")
    with pytest.raises(ConfigError, match=r"episode_000000.npz: no episode"):
        export_steps(tmp_path, tmp_path / "dataset", fps=10)
    with pytest.raises(ContractError, match="must be Box or Discrete"):
        RecordSteps(gymnasium.make("Blackjack-v1"), tmp_path)
