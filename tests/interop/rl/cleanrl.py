"""A PPO in one file behind the chain of wrappers that such files use, on SyncVectorEnv and on AsyncVectorEnv."""

import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path

import gymnasium
import numpy as np
import torch
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv, VectorEnv
from gymnasium.wrappers import (
    ClipAction,
    FlattenObservation,
    FrameStackObservation,
    NormalizeObservation,
    NormalizeReward,
    RecordEpisodeStatistics,
    RecordVideo,
    TimeAwareObservation,
    TransformObservation,
    TransformReward,
)
from torch import nn

ENVS = 2
GAMMA = 0.99
ROLLOUT = 125  # [steps] of each environment between updates


def train(name: str, steps: int) -> str:
    warnings.simplefilter("error")
    torch.manual_seed(1)
    torch.set_num_threads(1)
    told = [learn(kind([maker(name)] * ENVS), steps) for kind in (SyncVectorEnv, AsyncVectorEnv)]
    made = gymnasium.make_vec(name, num_envs=ENVS, vectorization_mode="sync", wrappers=chain(), max_steps=100)
    told.append(learn(made, 500))
    with tempfile.TemporaryDirectory() as folder:
        film(Path(folder), name)
    stacked(name)
    return ", ".join(told)


def chain() -> list[Callable[[gymnasium.Env], gymnasium.Env]]:
    """The wrappers, innermost first."""
    return [
        FlattenObservation,
        RecordEpisodeStatistics,
        ClipAction,
        NormalizeObservation,
        lambda env: TransformObservation(env, lambda values: np.clip(values, -10, 10), env.observation_space),
        lambda env: NormalizeReward(env, gamma=GAMMA),
        lambda env: TransformReward(env, lambda reward: float(np.clip(reward, -10, 10))),
    ]


def maker(name: str) -> Callable[[], gymnasium.Env]:
    def make() -> gymnasium.Env:
        env = gymnasium.make(name)
        for wrapper in chain():
            env = wrapper(env)
        return env

    return make


class Agent(nn.Module):
    """A mean and a value, each by one hidden layer."""

    def __init__(self, size: int, actions: int) -> None:
        super().__init__()
        self.mean = nn.Sequential(nn.Linear(size, 32), nn.Tanh(), nn.Linear(32, actions))
        self.value = nn.Sequential(nn.Linear(size, 32), nn.Tanh(), nn.Linear(32, 1))
        self.log_std = nn.Parameter(torch.zeros(actions))

    def policy(self, seen: torch.Tensor) -> torch.distributions.Normal:
        return torch.distributions.Normal(self.mean(seen), self.log_std.exp())


def learn(envs: VectorEnv, steps: int) -> str:
    agent = Agent(envs.single_observation_space.shape[0], envs.single_action_space.shape[0])
    optimizer = torch.optim.Adam(agent.parameters(), lr=3e-4)
    episodes: list[float] = []
    seen, _ = envs.reset(seed=1)
    seen = torch.as_tensor(seen, dtype=torch.float32)
    for _ in range(steps // (ENVS * ROLLOUT)):
        rollout, seen = collect(envs, agent, seen, episodes)
        loss = update(agent, optimizer, *rollout)
        assert np.isfinite(loss)
    envs.close()
    assert episodes
    return f"{type(envs.unwrapped).__name__} {np.mean(episodes):.2f}"


def collect(envs: VectorEnv, agent: Agent, seen: torch.Tensor, episodes: list[float]) -> tuple:
    kept = []
    for _ in range(ROLLOUT):
        with torch.no_grad():
            policy = agent.policy(seen)
            action = policy.sample()
            before = (seen, action, policy.log_prob(action).sum(1), agent.value(seen).squeeze(1))
        observations, rewards, terminated, truncated, infos = envs.step(action.numpy())
        seen = torch.as_tensor(observations, dtype=torch.float32)
        over = torch.as_tensor(terminated | truncated, dtype=torch.float32)
        kept.append((*before, torch.as_tensor(rewards, dtype=torch.float32), over))
        if "episode" in infos:
            episodes += infos["episode"]["r"][infos["_episode"]].tolist()
    columns = [torch.stack(column) for column in zip(*kept, strict=True)]
    with torch.no_grad():
        after = agent.value(seen).squeeze(1)
    returns = []
    for reward, over in zip(reversed(columns[4]), reversed(columns[5]), strict=True):
        after = reward + GAMMA * after * (1.0 - over)
        returns.insert(0, after)
    return (*columns[:4], torch.stack(returns)), seen


def update(agent: Agent, optimizer: torch.optim.Optimizer, *rollout: torch.Tensor) -> float:
    seen, action, log_prob, value, returns = (column.flatten(0, 1) for column in rollout)
    advantage = returns - value
    advantage = (advantage - advantage.mean()) / (advantage.std() + 1e-8)
    ratio = (agent.policy(seen).log_prob(action).sum(1) - log_prob).exp()
    surrogate = torch.minimum(ratio * advantage, ratio.clamp(0.8, 1.2) * advantage).mean()
    loss = (agent.value(seen).squeeze(1) - returns).square().mean() - surrogate
    optimizer.zero_grad()
    loss.backward()
    optimizer.step()
    return loss.item()


def film(folder: Path, name: str) -> None:
    env = gymnasium.make(name, render_mode="rgb_array", max_steps=5)
    env = RecordVideo(env, str(folder / "videos"), disable_logger=True)
    env = RecordEpisodeStatistics(env)
    env.reset(seed=1)
    for _ in range(5):
        *_, info = env.step(env.action_space.sample())
    env.close()
    assert info["episode"]["l"] <= 5
    assert list((folder / "videos").glob("*.mp4"))


def stacked(name: str) -> None:
    env = FrameStackObservation(TimeAwareObservation(FlattenObservation(gymnasium.make(name))), 4)
    observation, _ = env.reset(seed=1)
    assert observation in env.observation_space
    env.close()
