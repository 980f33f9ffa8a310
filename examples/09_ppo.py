"""PPO in one file: learn to drive to goals through places never seen, from 72 lidar beams and the goal.

    python 09_ppo.py --seed 1 --save policy

trains on generated scenes alone and then drives the `reactive` episodes through the seven scenes that have names. It
needs `pip install "threewe[rl]"`. With --save it writes policy.safetensors, policy.onnx and policy.json: the weights,
the same as a graph for any runtime, and the figures.

Proximal policy optimisation: Schulman et al. 2017. Generalised advantages: Schulman et al. 2016. A critic that sees
more than the policy: Pinto et al. 2018.
"""

import argparse
import json
import time
import warnings
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import torch
from safetensors.torch import load_file, save_file
from threewe.gym import VectorEnv
from threewe.gym.episodes import evaluate, load_episodes
from torch import nn
from torch.distributions import Normal

BEAMS = 72
SPANS = (4.0, 16.0, 64.0)  # steps, of the averages that are remembered
FEATURES = 2 * BEAMS + 2 + 2 * len(SPANS)
OBSERVED = {"observations": ("lidar", "goal"), "lidar_beams": BEAMS}


@dataclass
class Settings:
    """What a run is made of. Steps are counted over all environments."""

    seed: int = 1
    scenes: int = 12  # generated ones, trained on
    difficulty: float = 0.5
    gate: str = "limits"  # who may touch learns not to; with the collision monitor it would stand before things
    episodes: str = "reactive"
    control_rate: float = 5.0  # [Hz]
    num_envs: int = 256
    rollout: int = 32  # steps of each environment between updates
    updates: int = 60
    epochs: int = 6
    minibatches: int = 6
    learning_rate: float = 1.5e-3  # falls to 0
    discount: float = 0.99
    trace: float = 0.95  # lambda of the advantages
    clip: float = 0.2
    entropy: float = 0.005
    reward_scale: float = 0.2
    haste: float = 0.05  # taken off the reward of each step: who stands before a thing must not feel safe
    max_steps: int = 120  # of an episode in training
    threads: int = 2  # of the simulator


class Policy(nn.Module):
    """Scan (n, 72) [m], goal (n, 2) [m] and trail (n, 3, 2) [m] to actions (n, 3) in [-1, 1] and the next trail.

    The base drives in all directions alike, so it never turns, and what it sees is turned until the goal lies ahead: it
    needs to learn everything only once. The trail is its memory: averages of where the goal was, over three spans of
    time, which tell from where it has come and how long it has been here. It begins as the goal, three times.
    """

    def __init__(self) -> None:
        super().__init__()
        self.actor = network(FEATURES, 2)
        self.log_deviation = nn.Parameter(torch.full((2,), -0.7))
        nn.init.orthogonal_(self.actor[-1].weight, 0.01)

    def forward(
        self, lidar: torch.Tensor, goal: torch.Tensor, trail: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        velocity = self.mean(features(lidar, goal, trail), goal).clamp(-1.0, 1.0)
        return nn.functional.pad(velocity, (0, 1)), followed(trail, goal)

    def mean(self, seen: torch.Tensor, goal: torch.Tensor) -> torch.Tensor:
        straight_on = torch.tensor([1.0, 0.0])  # what it does before it has learned anything
        return turned(self.actor(seen) + straight_on, direction(goal))


def features(lidar: torch.Tensor, goal: torch.Tensor, trail: torch.Tensor) -> torch.Tensor:
    """What a policy looks at, counter-clockwise from the goal's direction; what is near counts most."""
    bearing = torch.atan2(goal[:, 1], goal[:, 0])
    first = torch.round((bearing + torch.pi) * (BEAMS / (2.0 * torch.pi))).long()  # beam 0 looks back
    ranges = lidar.gather(1, (first[:, None] + torch.arange(BEAMS)) % BEAMS)
    seen = ranges > 0.0  # 0 m is no measurement
    near = torch.where(seen, torch.exp(-ranges), 0.0)
    far = torch.where(seen, torch.exp(-ranges / 4.0), 0.0)
    distance = goal.norm(dim=1, keepdim=True)
    backwards = direction(goal) * torch.tensor([1.0, -1.0])
    came_by = turned(trail - goal[:, None], backwards[:, None]).flatten(1)
    return torch.cat([near, far, torch.exp(-distance), torch.exp(-distance / 4.0), came_by], dim=1)


def followed(trail: torch.Tensor, goal: torch.Tensor) -> torch.Tensor:
    """The trail, a step later."""
    return trail + (goal[:, None] - trail) / torch.tensor(SPANS)[:, None]


def fresh(goal: torch.Tensor) -> torch.Tensor:
    """The trail at an episode's beginning."""
    return goal[:, None].repeat(1, len(SPANS), 1)


def direction(goal: torch.Tensor) -> torch.Tensor:
    return goal / goal.norm(dim=1, keepdim=True).clamp_min(1e-3)


def turned(vectors: torch.Tensor, by: torch.Tensor) -> torch.Tensor:
    """Vectors (..., 2), turned by the angles of directions (..., 2)."""
    (x, y), (cos, sin) = vectors.unbind(-1), by.unbind(-1)
    return torch.stack([cos * x - sin * y, sin * x + cos * y], dim=-1)


def network(inputs: int, outputs: int) -> nn.Sequential:
    return nn.Sequential(
        nn.Linear(inputs, 64), nn.Tanh(), nn.Linear(64, 64), nn.Tanh(), nn.Linear(64, outputs)
    )  # fmt: skip


class Critic(nn.Module):
    """What is seen and the true length of the way left (n, 1) [m] to the return that is expected."""

    def __init__(self) -> None:
        super().__init__()
        self.net = network(FEATURES + 1, 1)

    def forward(self, seen: torch.Tensor, way_left: torch.Tensor) -> torch.Tensor:
        return self.net(torch.cat([seen, way_left / 4.0], dim=1)).squeeze(1)


@dataclass
class Rollout:
    """Steps of all environments, shape (rollout, num_envs, ...)."""

    seen: torch.Tensor
    goal: torch.Tensor
    way_left: torch.Tensor
    actions: torch.Tensor
    log_probs: torch.Tensor
    rewards: torch.Tensor
    values: torch.Tensor  # one more: of where the last step led
    terminated: torch.Tensor
    ended: torch.Tensor  # terminated or truncated
    valid: torch.Tensor  # False where a step only began the next episode


class Runner:
    """Drives the batch, and keeps count of how its episodes end."""

    def __init__(self, env: VectorEnv, settings: Settings) -> None:
        self.env, self.settings = env, settings
        observations, infos = env.reset(seed=1_000_000 * settings.seed)
        self._take(observations, infos, fresh(torch.from_numpy(observations["goal"])))
        self.began = torch.ones(settings.num_envs, dtype=torch.bool)
        self.successes: list[bool] = []

    def _take(self, observations, infos, trail: torch.Tensor) -> None:
        self.goal = torch.from_numpy(observations["goal"]).clone()
        self.seen = features(torch.from_numpy(observations["lidar"]), self.goal, trail)
        self.trail = followed(trail, self.goal)
        self.way_left = torch.from_numpy(infos["distance_to_goal"]).float().unsqueeze(1)

    @torch.no_grad()
    def run(self, policy: Policy, critic: Critic) -> Rollout:
        steps = []
        for _ in range(self.settings.rollout):
            choice = Normal(policy.mean(self.seen, self.goal), policy.log_deviation.exp())
            actions = choice.sample()
            now = (self.seen, self.goal, self.way_left, actions, choice.log_prob(actions).sum(1))
            value, valid = critic(self.seen, self.way_left), self.began
            observations, rewards, terminated, truncated, infos = self.env.step(
                nn.functional.pad(actions, (0, 1)).numpy()
            )
            ended = terminated | truncated
            self.successes += infos["success"][ended].tolist()
            begun = fresh(torch.from_numpy(observations["goal"]))
            self._take(observations, infos, torch.where(valid[:, None, None], self.trail, begun))
            self.began = torch.from_numpy(~ended)  # the step after an episode's end only begins the next one
            outcome = (
                torch.from_numpy(rewards).float(),
                value,
                torch.from_numpy(terminated.copy()),
                ~self.began,
                valid,
            )
            steps.append((*now, *outcome))
        columns = [torch.stack(column) for column in zip(*steps, strict=True)]
        columns[6] = torch.cat([columns[6], critic(self.seen, self.way_left)[None]])
        return Rollout(*columns)


def advantages(rollout: Rollout, settings: Settings) -> torch.Tensor:
    """Generalised advantages, from the last step to the first. What lies beyond a time limit is the critic's guess."""
    result = torch.zeros_like(rollout.rewards)
    following = torch.zeros_like(rollout.rewards[0])
    for t in reversed(range(len(result))):
        ahead = rollout.values[t + 1] * ~rollout.terminated[t]
        reward = settings.reward_scale * (rollout.rewards[t] - settings.haste)
        surprise = reward + settings.discount * ahead - rollout.values[t]
        following = surprise + settings.discount * settings.trace * following * ~rollout.ended[t]
        result[t] = following
    return result


def update(policy: Policy, critic: Critic, optimizer, rollout: Rollout, settings: Settings) -> None:
    gains = advantages(rollout, settings)
    returns = (gains + rollout.values[:-1])[rollout.valid]
    gains = gains[rollout.valid]
    gains = (gains - gains.mean()) / (gains.std() + 1e-8)
    kept = [rollout.seen, rollout.goal, rollout.way_left, rollout.actions, rollout.log_probs]
    seen, goal, way_left, actions, log_probs = (column[rollout.valid] for column in kept)

    for _ in range(settings.epochs):
        for some in torch.randperm(len(seen)).chunk(settings.minibatches):
            choice = Normal(policy.mean(seen[some], goal[some]), policy.log_deviation.exp())
            ratio = (choice.log_prob(actions[some]).sum(1) - log_probs[some]).exp()
            clipped = ratio.clamp(1.0 - settings.clip, 1.0 + settings.clip)
            policy_loss = -torch.min(ratio * gains[some], clipped * gains[some]).mean()
            value_loss = (critic(seen[some], way_left[some]) - returns[some]).square().mean()
            loss = policy_loss + 0.5 * value_loss - settings.entropy * choice.entropy().sum(1).mean()
            optimizer.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_([*policy.parameters(), *critic.parameters()], 0.5)
            optimizer.step()


def train(settings: Settings) -> tuple[Policy, list[dict]]:
    """The policy, and how it went: a point for each update."""
    wall, cpu = time.perf_counter(), time.process_time()
    torch.manual_seed(settings.seed)
    torch.set_num_threads(1)  # networks as small as these get slower by a second one
    env = VectorEnv(
        task="navigation",
        scene="procedural",
        num_scenes=settings.scenes,
        scene_seed=1000 * settings.seed,
        difficulty=settings.difficulty,
        episodes=settings.episodes,
        gate=settings.gate,
        control_rate=settings.control_rate,
        max_steps=settings.max_steps,
        num_envs=settings.num_envs,
        num_threads=settings.threads,
        copy=False,
        **OBSERVED,
    )
    policy, critic = Policy(), Critic()
    optimizer = torch.optim.Adam([*policy.parameters(), *critic.parameters()], settings.learning_rate)
    schedule = torch.optim.lr_scheduler.LinearLR(optimizer, 1.0, 0.0, settings.updates)
    runner = Runner(env, settings)
    curve = []
    for number in range(1, settings.updates + 1):
        runner.successes.clear()
        rollout = runner.run(policy, critic)
        update(policy, critic, optimizer, rollout, settings)
        schedule.step()
        point = {
            "steps": number * settings.rollout * settings.num_envs,
            "wall_s": round(time.perf_counter() - wall, 2),
            "cpu_s": round(time.process_time() - cpu, 2),
            "episodes": len(runner.successes),
            "success": float(np.mean(runner.successes)) if runner.successes else None,
        }
        curve.append(point)
        if number % 4 == 0 or number == settings.updates:
            print(
                "{steps:9,} steps {wall_s:6.1f} s: success {success} of {episodes} episodes".format(**point), flush=True
            )
    return policy, curve


class Driver:
    """The policy as `threewe.gym.episodes.evaluate` takes it, for episodes that begin with the first call."""

    def __init__(self, policy: nn.Module) -> None:
        self.policy, self.trail = policy, None

    @torch.no_grad()
    def __call__(self, observations: dict[str, np.ndarray]) -> np.ndarray:
        lidar, goal = torch.from_numpy(observations["lidar"]), torch.from_numpy(observations["goal"])
        actions, self.trail = self.policy(lidar, goal, fresh(goal) if self.trail is None else self.trail)
        return actions.numpy()


def success_by_scene(policy: nn.Module, settings: Settings, *, gate: str, each: int = 100) -> dict[str, float]:
    """The share of the `reactive` episodes that end well, in each scene that has a name."""
    listed = load_episodes("reactive_v1")["episodes"]
    result = {}
    print(f'reactive_v1, gate="{gate}":', flush=True)
    for scene in dict.fromkeys(episode.scene for episode in listed):
        chosen = [episode for episode in listed if episode.scene == scene][:each]
        options = {"gate": gate, "control_rate": settings.control_rate, "max_steps": 300, **OBSERVED}
        outcomes = evaluate(Driver(policy), chosen, num_threads=settings.threads, **options)
        result[scene] = sum(outcome.success for outcome in outcomes) / len(outcomes)
        print(f"{scene:14} {result[scene]:.0%} of {len(chosen)}", flush=True)
    return result


def save_weights(policy: Policy, path: Path) -> None:
    """As safetensors: numbers and their names, nothing that could run."""
    save_file(policy.state_dict(), path)


def load_weights(path: Path) -> Policy:
    policy = Policy()
    policy.load_state_dict(load_file(path))
    return policy


def export_onnx(policy: Policy, path: Path) -> None:
    """As a graph for any runtime and any number of robots: lidar, goal, trail -> action, next_trail."""
    inputs = {"lidar": torch.ones(2, BEAMS), "goal": torch.ones(2, 2), "trail": torch.zeros(2, 3, 2)}
    names = {"input_names": [*inputs], "output_names": ["action", "next_trail"]}
    axes = {name: {0: "robots"} for name in (*inputs, "action", "next_trail")}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of what this exporter says about itself: the new one needs another package
        torch.onnx.export(policy.eval(), tuple(inputs.values()), path, **names, dynamic_axes=axes, dynamo=False)


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--gate", choices=("full", "limits"), default="limits", help="in training")
    arguments.add_argument("--episodes", choices=("reactive", "standard"), default="reactive", help="in training")
    arguments.add_argument("--save", type=Path, help="path without suffix")
    arguments.add_argument("--quick", action="store_true", help="too short to learn much")
    given = arguments.parse_args()
    settings = Settings(seed=given.seed, gate=given.gate, episodes=given.episodes)
    if given.quick:
        settings.scenes, settings.num_envs, settings.updates = 2, 32, 3
    policy, curve = train(settings)
    each, gates = (2, ["full"]) if given.quick else (100, ["full", "limits"])
    success = {gate: success_by_scene(policy, settings, gate=gate, each=each) for gate in gates}
    if given.save:
        save_weights(policy, given.save.with_suffix(".safetensors"))
        export_onnx(policy, given.save.with_suffix(".onnx"))
        report = {"settings": asdict(settings), "success": success, "curve": curve}
        given.save.with_suffix(".json").write_text(json.dumps(report))


if __name__ == "__main__":
    main()
