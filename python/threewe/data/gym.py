"""Recording of learning environments: every step of a Gymnasium environment, a file for each finished episode."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, SupportsFloat

import gymnasium
import numpy as np
from gymnasium.core import ActType, ObsType
from numpy.typing import NDArray

from threewe._arguments import as_text
from threewe.data.step_files import RecoveredSteps, StepFile, finished, read_steps, recover_steps
from threewe.errors import ConfigError, ContractError

__all__ = ["RecordSteps", "RecoveredSteps", "export_steps", "recover_steps"]


class RecordSteps(gymnasium.Wrapper[ObsType, ActType, ObsType, ActType]):
    """Keeps observation, action, reward and end of each step, of any Gymnasium environment with Box observations, or a
    Dict of such. What stands in an image observation is BGR in 3we's environments, and RGB in an export.

    A finished episode is a file of its own, which is synchronized before it gets its name. A program that is killed
    loses the last 50 steps of the current episode at most, or those of the last second; `threewe data recover FOLDER`,
    or `recover_steps`, finishes what there is of it. An episode that `reset` cuts short is kept, too.

    Args:
        env: one environment, not a vector of them.
        folder: where the files go; one that holds some already gets more.
        task: what the agent is to do, in words; where left out the environment's id.

    Raises:
        ContractError: observations or actions that are neither a Box nor a Dict of them, nor Discrete actions.
        ConfigError: the folder cannot be written.
        RecordingError: the disk failed.
    """

    def __init__(
        self, env: gymnasium.Env[ObsType, ActType], folder: str | os.PathLike[str], task: str | None = None
    ) -> None:
        super().__init__(env)
        _check_spaces(env)
        self.folder = Path(folder)
        self.task = as_text("task", task if task is not None else env.spec.id if env.spec else "")
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ConfigError(f"{self.folder}: cannot be made: {error.strerror}") from None
        self._file: StepFile | None = None
        self._seen: dict[str, NDArray[Any]] = {}

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[ObsType, dict[str, Any]]:
        """As the environment's own; begins an episode."""
        self._save()
        observation, info = self.env.reset(seed=seed, options=options)
        self._seen = _parts(observation)
        return observation, info

    def step(self, action: ActType) -> tuple[ObsType, SupportsFloat, bool, bool, dict[str, Any]]:
        """As the environment's own; keeps the step, and the episode where it ends."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        self._file = self._file or StepFile(self.folder, self.task)
        row = {"action": action, "next.reward": np.float32(reward), "next.done": np.bool_(terminated or truncated)}
        self._file.add({**self._seen, **row})
        self._seen = _parts(observation)
        if terminated or truncated:
            self._save()
        return observation, reward, terminated, truncated, info

    def close(self) -> None:
        """Keeps the current episode, and closes the environment."""
        self._save()
        super().close()

    def _save(self) -> None:
        """Finishes the episode."""
        if self._file is not None:
            self._file.finish()
            self._file = None


def export_steps(folder: str | os.PathLike[str], output: str | os.PathLike[str], *, fps: int) -> Path:
    """Writes what `RecordSteps` has kept as a LeRobot dataset.

    Args:
        folder: of the episodes.
        output: the dataset's folder, which is not there yet.
        fps: [Hz] of the steps: 1 / (0.02 s x ticks a step) in 3we's environments.

    Raises:
        ConfigError: no episodes, files that are none, or an output that exists.
    """
    from threewe.data.lerobot import ArrayFrames, DatasetWriter

    files = finished(Path(folder))
    if not files:
        raise ConfigError(f"{folder}: there are no finished episodes; `threewe data recover` finishes others")
    first = read_steps(files[0])
    with DatasetWriter(Path(output), fps=fps, features=_features(first), codec="h264") as writer:
        for file in files:
            columns = read_steps(file)
            task = str(columns.pop("task"))
            videos = {
                name: ArrayFrames(columns.pop(name)[..., ::-1]) for name in list(columns) if _is_image(columns[name])
            }
            writer.add_episode({name: _column(values) for name, values in columns.items()}, task, videos)
    return Path(output)


def _parts(observation: Any) -> dict[str, NDArray[Any]]:
    """An observation by the names of its features."""
    if isinstance(observation, dict):
        return {f"observation.{name}": np.array(value) for name, value in observation.items()}
    return {"observation.state": np.array(observation)}


def _is_image(values: NDArray[Any]) -> bool:
    return values.ndim == 4 and values.shape[-1] == 3 and values.dtype == np.uint8


def _column(values: NDArray[Any]) -> NDArray[Any]:
    """As LeRobot has numbers: at least one a row, float32 rather than float64."""
    flat = values[:, None] if values.ndim == 1 else values
    return flat.astype(np.float32) if flat.dtype == np.float64 else flat


def _features(columns: dict[str, NDArray[Any]]) -> dict[str, dict[str, Any]]:
    features: dict[str, dict[str, Any]] = {}
    for name, values in columns.items():
        if name == "task":
            continue
        if _is_image(values):
            names = ["height", "width", "channels"]
            features[name] = {"dtype": "video", "shape": values.shape[1:], "names": names}
        else:
            column = _column(values)
            features[name] = {"dtype": str(column.dtype), "shape": column.shape[1:], "names": None}
    return features


def _check_spaces(env: gymnasium.Env[Any, Any]) -> None:
    space = env.observation_space
    spaces = list(space.values()) if isinstance(space, gymnasium.spaces.Dict) else [space]
    wrong = [one for one in spaces if not isinstance(one, gymnasium.spaces.Box | gymnasium.spaces.Discrete)]
    if not isinstance(env.action_space, gymnasium.spaces.Box | gymnasium.spaces.Discrete):
        wrong.append(env.action_space)
    if wrong:
        raise ContractError(f"observations and actions must be Box or Discrete, or a Dict of such, got {wrong[0]}")
