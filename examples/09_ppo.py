"""PPO in one file: learn to drive to goals through places never seen, from 72 lidar beams and the goal.

    python 09_ppo.py --seed 1 --save policy

trains on generated scenes alone and then drives the `reactive` episodes through the seven scenes that have names. It
needs `pip install "threewe[train]"`. With --save it writes policy.safetensors, policy.onnx and policy.json: the
weights, the same as a graph for any runtime, and the figures.

Proximal policy optimisation: Schulman et al. 2017. Generalised advantages: Schulman et al. 2016. A critic that sees
more than the policy: Pinto et al. 2018. Choices instead of a mean and a deviation: Tang & Agrawal 2020.
"""

import argparse
import json
import math
import os
import time
import warnings
from dataclasses import asdict, dataclass
from pathlib import Path

os.environ.setdefault("OMP_WAIT_POLICY", "passive")  # PyTorch's threads leave the CPUs to the simulator's, and back
import numpy as np
import torch
from safetensors.torch import load_file, save_file
from threewe import Scene
from threewe.gym import VectorEnv
from threewe.gym.episodes import evaluate, load_episodes
from torch import nn

BEAMS = 72
HEADINGS = 24  # that it chooses from, counter-clockwise from the goal's direction
SPEEDS = (1.0, 0.4)  # shares of the limit
CHOICES = HEADINGS * len(SPEEDS)
SPANS = (2.0, 8.0, 32.0, 128.0)  # [steps] of the averages that are remembered
CELLS = 40  # along a side of the map of where it has been, in whose middle the goal is
CELL = 0.4  # [m]
LOOKS = (0.7, 1.5)  # [m] how far away it looks into that map, all around
FEATURES = 2 * BEAMS + 2 + 2 * len(SPANS) + 1 + HEADINGS * len(LOOKS)


@dataclass(frozen=True)
class Lesson:
    """A part of the training, in places of its own."""

    noise: str
    scenes: int  # generated
    updates: int


@dataclass
class Settings:
    """What a run is made of. Steps are counted over all environments."""

    seed: int = 1
    # most of the time without noise, where a step costs half as much; then as it will be
    lessons: tuple[Lesson, ...] = (Lesson("ideal", 20, 95), Lesson("realistic", 12, 30))
    difficulty: tuple[float, float] = (0.2, 1.0)  # of the first and the last scene of a lesson
    gate: str = "full"  # the robot is stopped before things, and learns to get away from there
    blur: float = 0.02  # [m] standard deviation that is added to what the policy sees
    episodes: str = "reactive"
    control_rate: float = 5.0  # [Hz]
    max_steps: int = 250  # of an episode in training
    num_envs: int = 1024
    rollout: int = 16  # steps of each environment between updates
    epochs: int = 3
    minibatches: int = 4
    learning_rate: float = 1e-3  # falls to 0
    discount: float = 0.99
    trace: float = 0.95  # lambda of the advantages
    clip: float = 0.2
    entropy: float = 0.01  # falls to 0
    reward_scale: float = 0.2
    haste: float = 0.05  # taken off the reward of each step
    threads: int = 2


class Policy(nn.Module):
    """Chooses a velocity out of `CHOICES`: a heading and a speed.

    The base drives in all directions alike, so it never turns, and what it sees is turned until the goal lies ahead: it
    needs to learn everything only once. Out of dead ends memory helps. The trail (n, 4, 2) [m] is averages of where the
    goal was, over four spans of time; the visits (n, 40 * 40) count the steps spent in each cell of a map.
    """

    def __init__(self) -> None:
        super().__init__()
        self.actor = network(FEATURES, CHOICES)
        with torch.no_grad():  # before it has learned anything it rather drives towards the goal, fast
            self.actor[-1].weight *= 0.01
            self.actor[-1].bias[[0, 1, HEADINGS - 1]] += torch.tensor([2.0, 1.0, 1.0])

    def forward(
        self, lidar: torch.Tensor, goal: torch.Tensor, trail: torch.Tensor, visits: torch.Tensor, chance: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Scan (n, 72) [m], goal (n, 2) [m], trail, visits and chance to actions (n, 3) in [-1, 1], trail and visits.

        Chance, (n, 48) drawn from 0 to 1, decides between choices that are about as good, which gets it out of
        standstills. Where all of it is the same the best choice is taken.
        """
        choice = chosen(self.actor(features(lidar, goal, trail, visits)), chance)
        return actions_of(choice, goal), followed(trail, goal), visited(visits, goal)


def features(lidar: torch.Tensor, goal: torch.Tensor, trail: torch.Tensor, visits: torch.Tensor) -> torch.Tensor:
    """What a policy looks at, (n, FEATURES), counter-clockwise from the goal's direction; what is near counts most."""
    bearing = torch.atan2(goal[:, 1], goal[:, 0])
    first = torch.round((bearing + torch.pi) * (BEAMS / (2.0 * torch.pi))).long()  # beam 0 looks back
    ranges = lidar.gather(1, (first[:, None] + torch.arange(BEAMS)) % BEAMS)
    far = torch.exp(-ranges / 4.0) * (ranges > 0.0)  # 0 m is no measurement
    near = far.square().square()
    distance = goal.norm(dim=1, keepdim=True)
    backwards = direction(goal) * torch.tensor([1.0, -1.0])
    came_by = turned(trail - goal[:, None], backwards).flatten(1).clamp(-6.0, 6.0)
    around = turned(torch.cat([torch.zeros(1, 2), *(reach * compass(HEADINGS) for reach in LOOKS)]), direction(goal))
    been = 0.4 * torch.log1p(visits.gather(1, cell(around - goal[:, None])))
    return torch.cat([near, far, torch.exp(-distance), torch.exp(-distance / 4.0), came_by, been], dim=1)


def chosen(logits: torch.Tensor, chance: torch.Tensor) -> torch.Tensor:
    """One choice of each row, with the probabilities that the logits stand for (Gumbel 1954)."""
    return (logits - torch.log(-torch.log(chance.clamp(1e-6, 1.0 - 1e-6)))).argmax(dim=1)


def actions_of(choice: torch.Tensor, goal: torch.Tensor) -> torch.Tensor:
    velocities = torch.cat([speed * compass(HEADINGS) for speed in SPEEDS])
    velocity = turned(velocities[choice][:, None], direction(goal)).squeeze(1)
    return nn.functional.pad(velocity, (0, 1))


def compass(headings: int) -> torch.Tensor:
    angles = torch.arange(headings) * (2.0 * math.pi / headings)
    return torch.stack([angles.cos(), angles.sin()], dim=1)


def direction(goal: torch.Tensor) -> torch.Tensor:
    return goal / goal.norm(dim=1, keepdim=True).clamp_min(1e-3)


def turned(vectors: torch.Tensor, by: torch.Tensor) -> torch.Tensor:
    """Vectors (n or 1, k, 2), turned by the angles of directions (n, 2)."""
    (x, y), (cos, sin) = vectors.unbind(-1), by[:, None].unbind(-1)
    return torch.stack([cos * x - sin * y, sin * x + cos * y], dim=-1)


def cell(place: torch.Tensor) -> torch.Tensor:
    """Which of the cells holds places (n, k, 2) [m], seen from the goal; what is beyond the map is at its border."""
    column, row = (place / CELL + CELLS / 2).long().clamp(0, CELLS - 1).unbind(-1)
    return row * CELLS + column


def followed(trail: torch.Tensor, goal: torch.Tensor) -> torch.Tensor:
    """The trail, a step later."""
    return trail + (goal[:, None] - trail) / torch.tensor(SPANS)[:, None]


def visited(visits: torch.Tensor, goal: torch.Tensor) -> torch.Tensor:
    """The visits, a step later."""
    return visits.scatter_add(1, cell(-goal[:, None]), torch.ones_like(goal[:, :1]))


def nothing_yet(goal: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """Trail and visits at an episode's beginning."""
    return goal[:, None].repeat(1, len(SPANS), 1), torch.zeros(len(goal), CELLS * CELLS)


def network(inputs: int, outputs: int) -> nn.Sequential:
    layers = [nn.Linear(inputs, 128), nn.ReLU(), nn.Linear(128, 128), nn.ReLU(), nn.Linear(128, outputs)]
    for layer in layers[::2]:
        nn.init.orthogonal_(layer.weight, math.sqrt(2.0))
        nn.init.zeros_(layer.bias)
    return nn.Sequential(*layers)


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
    way_left: torch.Tensor
    choices: torch.Tensor
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
        self.trail, self.visits = nothing_yet(torch.from_numpy(observations["goal"]))
        self.going = torch.ones(settings.num_envs, dtype=torch.bool)
        self.successes: list[bool] = []
        self._take(observations, infos)

    def _take(self, observations, infos) -> None:
        """What is seen now, and what is remembered of it."""
        lidar, self.goal = torch.from_numpy(observations["lidar"]), torch.from_numpy(observations["goal"]).clone()
        lidar = (lidar + self.settings.blur * torch.randn(lidar.shape)).clamp_min(0.01) * (lidar > 0.0)
        self.trail = torch.where(self.going[:, None, None], self.trail, self.goal[:, None])
        self.visits[~self.going] = 0.0
        self.seen = features(lidar, self.goal, self.trail, self.visits)
        self.trail, self.visits = followed(self.trail, self.goal), visited(self.visits, self.goal)
        self.way_left = torch.from_numpy(infos["distance_to_goal"]).float().unsqueeze(1)

    @torch.no_grad()
    def run(self, policy: Policy, critic: Critic) -> Rollout:
        steps = []
        for _ in range(self.settings.rollout):
            log_probs = policy.actor(self.seen).log_softmax(1)
            choice = chosen(log_probs, torch.rand_like(log_probs))
            now = (self.seen, self.way_left, choice, log_probs.gather(1, choice[:, None]).squeeze(1))
            value, valid = critic(self.seen, self.way_left), self.going
            observations, rewards, terminated, truncated, infos = self.env.step(actions_of(choice, self.goal).numpy())
            ended = terminated | truncated
            self.successes += infos["success"][ended].tolist()
            self._take(observations, infos)
            outcome = [torch.from_numpy(array.copy()) for array in (terminated, ended)]
            steps.append((*now, torch.from_numpy(rewards).float(), value, *outcome, valid))
            self.going = ~outcome[1]  # the step after an episode's end only begins the next one
        columns = [torch.stack(column) for column in zip(*steps, strict=True)]
        columns[5] = torch.cat([columns[5], critic(self.seen, self.way_left)[None]])
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


def update(policy: Policy, critic: Critic, optimizer, rollout: Rollout, left: float, settings: Settings) -> None:
    """Some epochs over a rollout; `left` is the share of the training that lies ahead."""
    optimizer.param_groups[0]["lr"] = settings.learning_rate * left
    parameters = optimizer.param_groups[0]["params"]
    gains = advantages(rollout, settings)
    returns = (gains + rollout.values[:-1])[rollout.valid]
    gains = gains[rollout.valid]
    gains = (gains - gains.mean()) / (gains.std() + 1e-8)
    kept = [rollout.seen, rollout.way_left, rollout.choices, rollout.log_probs]
    seen, way_left, choices, log_probs = (column[rollout.valid] for column in kept)

    for _ in range(settings.epochs):
        for some in torch.randperm(len(seen)).chunk(settings.minibatches):
            now = policy.actor(seen[some]).log_softmax(1)
            ratio = (now.gather(1, choices[some, None]).squeeze(1) - log_probs[some]).exp()
            clipped = ratio.clamp(1.0 - settings.clip, 1.0 + settings.clip)
            policy_loss = -torch.min(ratio * gains[some], clipped * gains[some]).mean()
            value_loss = (critic(seen[some], way_left[some]) - returns[some]).square().mean()
            entropy = -(now.exp() * now).sum(1).mean()
            optimizer.zero_grad()
            (policy_loss + 0.5 * value_loss - left * settings.entropy * entropy).backward()
            nn.utils.clip_grad_norm_(parameters, 0.5)
            optimizer.step()


def train(settings: Settings) -> tuple[Policy, list[dict]]:
    """The policy, and how it went: a point for each update."""
    wall, cpu = time.perf_counter(), time.process_time()
    torch.manual_seed(settings.seed)
    torch.set_num_threads(settings.threads)
    policy, critic = Policy(), Critic()
    optimizer = torch.optim.Adam([*policy.parameters(), *critic.parameters()], eps=1e-5, fused=True)
    curve, total = [], sum(lesson.updates for lesson in settings.lessons)
    for place, lesson in enumerate(settings.lessons):
        runner = Runner(classroom(lesson, 1000 * settings.seed + 100 * place, settings), settings)
        for _ in range(lesson.updates):
            runner.successes.clear()
            rollout = runner.run(policy, critic)
            update(policy, critic, optimizer, rollout, 1.0 - len(curve) / total, settings)
            point = {
                "steps": (len(curve) + 1) * settings.rollout * settings.num_envs,
                "wall_s": round(time.perf_counter() - wall, 2),
                "cpu_s": round(time.process_time() - cpu, 2),
                "episodes": len(runner.successes),
                "success": float(np.mean(runner.successes)) if runner.successes else None,
            }
            curve.append(point)
            if len(curve) % 10 == 0 or len(curve) == total:
                line = "{steps:9,} steps {wall_s:6.1f} s: success {success} of {episodes} episodes"
                print(line.format(**point), flush=True)
    return policy, curve


def classroom(lesson: Lesson, seed: int, settings: Settings) -> VectorEnv:
    """Places from sparse to crowded, and robots in them."""
    difficulties = np.linspace(*settings.difficulty, lesson.scenes).tolist()
    return VectorEnv(
        task="navigation",
        scene=[Scene.generate(seed + i, difficulty=difficulty) for i, difficulty in enumerate(difficulties)],
        noise=lesson.noise,
        episodes=settings.episodes,
        gate=settings.gate,
        observations=("lidar", "goal"),
        lidar_beams=BEAMS,
        control_rate=settings.control_rate,
        max_steps=settings.max_steps,
        num_envs=settings.num_envs,
        num_threads=settings.threads,
        copy=False,
    )


class Driver:
    """The policy as `threewe.gym.episodes.evaluate` takes it, for episodes that begin with the first call."""

    def __init__(self, policy: nn.Module, seed: int) -> None:
        self.policy, self.memory, self.chance = policy, None, torch.Generator().manual_seed(seed)

    @torch.no_grad()
    def __call__(self, observations: dict[str, np.ndarray]) -> np.ndarray:
        lidar, goal = torch.from_numpy(observations["lidar"]), torch.from_numpy(observations["goal"])
        chance = torch.rand(len(goal), CHOICES, generator=self.chance)
        actions, *self.memory = self.policy(lidar, goal, *(self.memory or nothing_yet(goal)), chance)
        return actions.numpy()


def success_by_scene(policy: nn.Module, settings: Settings, episodes: list, *, gate: str) -> dict[str, float]:
    """The share of episodes that end well, in each scene."""
    result = {}
    for scene in dict.fromkeys(episode.scene for episode in episodes):
        here = [episode for episode in episodes if episode.scene == scene]
        outcomes = evaluate(
            Driver(policy, settings.seed),
            here,
            gate=gate,
            control_rate=settings.control_rate,
            max_steps=300,
            observations=("lidar", "goal"),
            lidar_beams=BEAMS,
            num_threads=settings.threads,
        )
        result[scene] = sum(outcome.success for outcome in outcomes) / len(outcomes)
        print(f'{scene:14} {result[scene]:.0%} of {len(here)}, gate="{gate}"', flush=True)
    return result


def save_weights(policy: Policy, path: Path) -> None:
    """As safetensors: numbers and their names, nothing that could run."""
    save_file(policy.state_dict(), path)


def load_weights(path: Path) -> Policy:
    policy = Policy()
    policy.load_state_dict(load_file(path))
    return policy


def export_onnx(policy: Policy, path: Path) -> None:
    """As a graph for any runtime and any number of robots."""
    goal = torch.ones(2, 2)
    memory = dict(zip(("trail", "visits"), nothing_yet(goal), strict=True))
    inputs = {"lidar": torch.ones(2, BEAMS), "goal": goal, **memory, "chance": torch.full((2, CHOICES), 0.5)}
    outputs = ("action", "next_trail", "next_visits")
    axes = {name: {0: "robots"} for name in (*inputs, *outputs)}
    names = {"input_names": [*inputs], "output_names": [*outputs], "dynamic_axes": axes, "opset_version": 17}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of what this exporter says about itself: the new one needs another package
        torch.onnx.export(policy.eval(), tuple(inputs.values()), path, **names, dynamo=False)


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--save", type=Path, help="path without suffix")
    arguments.add_argument("--quick", action="store_true", help="too short to learn much")
    given = arguments.parse_args()
    settings = Settings(seed=given.seed)
    if given.quick:
        settings.num_envs, settings.lessons = 32, (Lesson("ideal", 2, 2), Lesson("realistic", 1, 1))
    policy, curve = train(settings)
    episodes = load_episodes("reactive_v1")["episodes"]
    gates = ("full", "limits")
    if given.quick:
        episodes, gates = episodes[::50], gates[:1]
    success = {gate: success_by_scene(policy, settings, episodes, gate=gate) for gate in gates}
    if given.save:
        save_weights(policy, given.save.with_suffix(".safetensors"))
        export_onnx(policy, given.save.with_suffix(".onnx"))
        report = {"settings": asdict(settings), "success": success, "curve": curve}
        given.save.with_suffix(".json").write_text(json.dumps(report))


if __name__ == "__main__":
    main()
