"""Learning environments that are recorded, and what LeRobot's format makes of them."""

from pathlib import Path

import gymnasium
import numpy as np
import pytest
import threewe  # noqa: F401 (registers the environments)
from threewe.data.gym import RecordSteps, export_steps
from threewe.data.lerobot import Dataset, validate
from threewe.errors import ConfigError, ContractError


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


def test_what_is_no_episode_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="there are no episodes"):
        export_steps(tmp_path, tmp_path / "dataset", fps=10)
    (tmp_path / "episode_000000.npz").write_bytes(b"junk")
    with pytest.raises(ConfigError, match=r"episode_000000.npz: no episode"):
        export_steps(tmp_path, tmp_path / "dataset", fps=10)
    with pytest.raises(ContractError, match="must be Box or Discrete"):
        RecordSteps(gymnasium.make("Blackjack-v1"), tmp_path)
