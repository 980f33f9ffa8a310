"""A hand-made map with a head learned by PPO, in one file: drive to goals through places never seen.

What is learned is what to make of 72 lidar beams and of the map; the map itself and the lengths of ways on it are
arithmetic, and drive well by themselves: --untrained shows how well. 12_end_to_end.py learns without them.

    python 09_ppo.py --seed 1 --save policy

trains on generated scenes alone and then drives the `reactive` episodes through the seven scenes that have names. It
needs `pip install "threewe[train]"`. With --save it writes policy.safetensors, policy.onnx and policy.json: the
weights, the same as a graph for any runtime, and the figures.

With --workers 4 --engine ray --address auto four actors of a Ray cluster drive a quarter of the environments each: the
weights go out to them, batches come back, and they are those of --workers 4 in this process.

Proximal policy optimisation: Schulman et al. 2017. Generalised advantages: Schulman et al. 2016. A critic that sees
more than the policy: Pinto et al. 2018. Choices instead of a mean and a deviation: Tang & Agrawal 2020. Lengths of ways
that grow truer with each step: Korf 1990; within a policy that learns: Tamar et al. 2016.
"""

import argparse
import json
import math
import time
import warnings
from collections import namedtuple
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
import torch
from safetensors.torch import load_file, save_file
from threewe import Scene
from threewe.benchmark import load_episodes
from threewe.benchmark.ray_engine import cluster
from threewe.gym import VectorEnv
from threewe.gym.episodes import evaluate
from torch import nn

BEAMS = 72
HEADINGS = 24  # that it chooses from, counter-clockwise from the goal's direction
SPEEDS = (1.0, 0.4)  # shares of the limit
CHOICES = HEADINGS * len(SPEEDS)
DRIVING = {"task": "navigation", "observations": ("lidar", "goal"), "lidar_beams": BEAMS, "control_rate": 5.0}
CELLS = 65  # along a side of the map, in whose middle the goal is
CELL = 0.25  # [m]
SIGHT = 4.0  # [m] how far things go on the map
THING = 3.0  # [m] by which a way is longer that leads through a cell where something stands
STAY = 0.05  # [m], likewise, for each step that was spent there
SWEEPS = 3  # over the map, each step
LOOKS = (0.6, 1.3)  # [m] how far away it looks into the map, all around
HAND_SET_TRUST = 0.5  # in the map, of a policy that has learned nothing; 0.2 to 1 do about as well
FEATURES = 2 * BEAMS + 4 + HEADINGS * (1 + len(LOOKS))


@dataclass
class Settings:
    """What a run is made of. Steps are counted over all environments."""

    seed: int = 1
    # noise, generated scenes, updates: first without noise, where a step costs half as much; then as it will be
    lessons: tuple[tuple[str, int, int], ...] = (("ideal", 20, 26), ("realistic", 12, 14))
    randomization: str = "none"  # how its robots differ from their profile
    blur: float = 0.02  # [m] standard deviation that is added to what the policy sees
    max_steps: int = 200  # of an episode in training
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
    threads: int = 2  # of the simulator, and of what is remembered
    workers: int = 1  # that share the environments; each draws for itself


class Policy(nn.Module):
    """Chooses a velocity out of `CHOICES`: a heading and a speed.

    The base drives in all directions alike, so it never turns, and what it sees is turned until the goal lies ahead: it
    needs to learn everything only once. Out of dead ends memory helps, maps of 16 x 16 m that are handed in and out:

    - grid (n, 65 * 65): -1 in cells where something was seen, in others the number of steps spent there.
    - ways (n, 65 * 65) [m]: from each cell to the goal; at first the straight line, with each step nearer the truth.
    """

    def __init__(self) -> None:
        super().__init__()
        self.actor = network(FEATURES, CHOICES)
        self.trust = nn.Parameter(torch.zeros(len(LOOKS), 1))  # in what the map says; to begin with, none
        with torch.no_grad():  # before it has learned anything it rather drives towards the goal, fast
            self.actor[-1].weight *= 0.01
            self.actor[-1].bias[[0, 1, HEADINGS - 1]] += torch.tensor([2.0, 1.0, 1.0])

    def forward(self, lidar, goal, grid, ways, chance) -> tuple[torch.Tensor, ...]:
        """Scan (n, 72) [m], goal (n, 2) [m], memory and chance to actions (n, 3) in [-1, 1] and memory.

        Chance, (n, 48) drawn from 0 to 1, decides between choices that are about as good, which gets it out of
        standstills. Where all of it is the same the best choice is taken.
        """
        memory = remembered(lidar, goal, grid, ways)
        choice = chosen(self.logits(features(lidar, goal, *memory)), chance)
        return actions_of(choice, goal), *memory

    @classmethod
    def untrained(cls) -> "Policy":
        """What the map does alone: it drives where the way is shorter by the map, with nothing learned."""
        policy = cls()
        with torch.no_grad():
            policy.trust.fill_(HAND_SET_TRUST)
        return policy

    def logits(self, seen: torch.Tensor) -> torch.Tensor:
        longer = seen[:, -HEADINGS * len(LOOKS) :].view(-1, len(LOOKS), HEADINGS)
        return self.actor(seen) - 20.0 * (self.trust * longer).sum(1).repeat(1, len(SPEEDS))


def features(lidar, goal, grid, ways) -> torch.Tensor:
    """What a policy looks at, (n, FEATURES), counter-clockwise from the goal's direction; what is near counts most."""
    bearing = torch.atan2(goal[:, 1], goal[:, 0])
    first = torch.round((bearing + torch.pi) * (BEAMS / (2.0 * torch.pi))).long()  # beam 0 looks back
    ranges = lidar.gather(1, (first[:, None] + torch.arange(BEAMS)) % BEAMS)
    far = torch.exp(-ranges / 4.0) * (ranges > 0.0)  # 0 m is no measurement
    near = far.square().square()
    distance = goal.norm(dim=1, keepdim=True)
    free = room(torch.where(ranges > 0.0, ranges, 12.0))
    ahead = turned(compass(HEADINGS)[None], direction(goal))
    spots = [0.0 * ahead[:, :1], *(free.clamp_max(look)[..., None] * ahead for look in LOOKS)]  # not behind things
    left = ways.gather(1, cell(torch.cat(spots, dim=1) - goal[:, None]))
    here, there = left[:, :1], left[:, 1:]
    longer = [(here - distance).clamp(0.0, 4.0), (there - here).clamp(-2.0, 1.0)]
    stay = grid.gather(1, cell(-goal[:, None])).log1p()
    how_far = [torch.exp(-distance), torch.exp(-distance / 4.0)]
    return torch.cat([near, far, *how_far, stay, free.clamp_max(2.0), *longer], dim=1)


def room(ranges: torch.Tensor) -> torch.Tensor:
    """Ranges (n, 72) [m] to how far a robot 0.4 m wide can drive in each heading, (n, 24) [m]."""
    beside = torch.arange(-15, 16)  # beams on both sides that matter
    apart = beside * (2.0 * math.pi / BEAMS)
    beams = ranges[:, (torch.arange(HEADINGS)[:, None] * (BEAMS // HEADINGS) + beside) % BEAMS]
    ahead = torch.where(beams * apart.sin().abs() < 0.2, beams * apart.cos(), 12.0).amin(2)
    return (ahead - 0.2).clamp_min(0.0)


def chosen(logits: torch.Tensor, chance: torch.Tensor) -> torch.Tensor:
    """One choice of each row, with the probabilities that the logits stand for (Gumbel 1954)."""
    return (logits - torch.log(-torch.log(chance.clamp(1e-6, 1.0 - 1e-6)))).argmax(dim=1)


def actions_of(choice: torch.Tensor, goal: torch.Tensor) -> torch.Tensor:
    velocities = torch.cat([speed * compass(HEADINGS) for speed in SPEEDS])
    return nn.functional.pad(turned(velocities[choice][:, None], direction(goal)).squeeze(1), (0, 1))


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
    column, row = (place / CELL + CELLS / 2).long().clamp(1, CELLS - 2).unbind(-1)
    return row * CELLS + column


def nothing_yet(goal: torch.Tensor) -> list[torch.Tensor]:
    """What is remembered at an episode's beginning."""
    ways = ((torch.cartesian_prod(*[torch.arange(CELLS)] * 2) - CELLS // 2) * CELL).norm(dim=1)
    grid = nn.functional.pad(torch.zeros(CELLS - 2, CELLS - 2), (1, 1, 1, 1), value=-30.0)  # no agent leaves the map
    return [whole.flatten().repeat(len(goal), 1) for whole in (grid, ways)]


def remembered(lidar, goal, grid, ways) -> list[torch.Tensor]:
    """What is remembered, a step later."""
    grid = mapped(lidar, goal, grid)
    return [grid, swept(ways, grid)]


def mapped(lidar: torch.Tensor, goal: torch.Tensor, grid: torch.Tensor) -> torch.Tensor:
    """Puts what is seen on the map, but not where it has been itself. Things are taken to be 15 cm deep."""
    depths = torch.cat([lidar + 0.1, lidar + 0.25], dim=1)[..., None]
    things = cell(depths * compass(BEAMS).roll(BEAMS // 2, 0).repeat(2, 1) - goal[:, None])
    things = things * ((lidar > 0.0) & (lidar < SIGHT)).repeat(1, 2)  # the others to a corner that is never looked at
    before = grid.gather(1, things)
    grid = grid.scatter(1, things, torch.where(before > 0.0, before, -1.0))
    here = cell(-goal[:, None])
    return grid.scatter(1, here, grid.gather(1, here).clamp_min(0.0) + 1.0)


def swept(ways: torch.Tensor, grid: torch.Tensor) -> torch.Tensor:
    """From each cell it is as far as from the nearest of its eight neighbours, and the way there."""
    inner, middle = slice(CELLS + 1, -CELLS - 1), CELLS * CELLS // 2 - CELLS - 1
    effort = (CELL + THING * (-grid).clamp_min(0.0) + STAY * grid.clamp_min(0.0))[:, inner]
    for _ in range(SWEEPS):
        beside = torch.minimum(ways[:, :-2], ways[:, 2:])
        above = torch.minimum(ways[:, : -2 * CELLS], ways[:, 2 * CELLS :])
        askew = torch.minimum(beside[:, : -2 * CELLS], beside[:, 2 * CELLS :])
        straight = torch.minimum(beside[:, CELLS:-CELLS], above[:, 1:-1])
        ways = torch.minimum(straight + effort, torch.add(askew, effort, alpha=math.sqrt(2.0)))
        ways[:, middle] = 0.0  # the goal
        ways = nn.functional.pad(ways, (CELLS + 1, CELLS + 1), value=100.0)
    return ways


def network(inputs: int, outputs: int) -> nn.Sequential:
    layers = [nn.Linear(inputs, 128), nn.ReLU(), nn.Linear(128, 128), nn.ReLU(), nn.Linear(128, outputs)]
    for layer in layers[::2]:
        nn.init.orthogonal_(layer.weight, math.sqrt(2.0))
        nn.init.zeros_(layer.bias)
    return nn.Sequential(*layers)


def worth(critic: nn.Module, seen: torch.Tensor, way_left: torch.Tensor) -> torch.Tensor:
    """The return that is expected by what is seen and the true length of the way left, (n, 1) [m]."""
    return critic(torch.cat([seen, way_left / 4.0], dim=1)).squeeze(1)


# Tensors (rollout, num_envs, ...), of values one more: where the last step led. Ended is terminated or truncated; not
# valid are steps that only began the next episode.
Rollout = namedtuple("Rollout", "seen way_left choices log_probs rewards values terminated ended valid")


class Runner:
    """Drives one worker's share of a lesson's environments, and keeps count of how its episodes end."""

    def __init__(self, settings: Settings, lesson: int, worker: int) -> None:
        self.settings, share = settings, settings.num_envs // settings.workers
        noise, scenes, _ = settings.lessons[lesson]
        self.env = classroom(noise, scenes, 1000 * settings.seed + 100 * lesson, share, settings)
        self.pool = ThreadPoolExecutor(settings.threads)
        self.random = torch.Generator().manual_seed((1000 * settings.seed + lesson) * 1000 + worker)
        observations, infos = self.env.reset(seed=1_000_000 * settings.seed + worker * share)
        self.memory = nothing_yet(torch.from_numpy(observations["goal"]))
        self.going = torch.ones(share, dtype=torch.bool)
        self.successes: list[bool] = []
        self._take(observations, infos)

    def _take(self, observations, infos) -> None:
        """What is seen now, and what is remembered of it."""
        lidar, self.goal = torch.from_numpy(observations["lidar"]), torch.from_numpy(observations["goal"]).clone()
        blur = self.settings.blur * torch.randn(lidar.shape, generator=self.random)
        lidar = (lidar + blur).clamp_min(0.01) * (lidar > 0.0)
        for kept, fresh in zip(self.memory, nothing_yet(self.goal[~self.going]), strict=True):
            kept[~self.going] = fresh
        columns = (column.split(64) for column in (lidar, self.goal, *self.memory))  # as many as the cache holds
        self.memory = [torch.cat(parts) for parts in zip(*self.pool.map(remembered, *columns), strict=True)]
        self.seen = features(lidar, self.goal, *self.memory)
        self.way_left = torch.from_numpy(infos["distance_to_goal"]).float().unsqueeze(1)

    @torch.no_grad()
    def run(self, policy: Policy, critic: nn.Module) -> tuple[Rollout, list[bool]]:
        """The next steps of all environments, and which of the episodes that ended were won."""
        steps, self.successes = [], []
        for _ in range(self.settings.rollout):
            log_probs = policy.logits(self.seen).log_softmax(1)
            choice = chosen(log_probs, torch.rand(log_probs.shape, generator=self.random))
            now = (self.seen, self.way_left, choice, log_probs.gather(1, choice[:, None]).squeeze(1))
            value, valid = worth(critic, self.seen, self.way_left), self.going
            observations, rewards, terminated, truncated, infos = self.env.step(actions_of(choice, self.goal).numpy())
            ended = terminated | truncated
            self.successes += infos["success"][ended].tolist()
            self._take(observations, infos)
            outcome = [torch.from_numpy(array.copy()) for array in (terminated, ended)]
            steps.append((*now, torch.from_numpy(rewards).float(), value, *outcome, valid))
            self.going = ~outcome[1]  # the step after an episode's end only begins the next one
        columns = [torch.stack(column) for column in zip(*steps, strict=True)]
        columns[5] = torch.cat([columns[5], worth(critic, self.seen, self.way_left)[None]])
        return Rollout(*columns), self.successes


class Local:
    """Sampling in this process, one worker after the other."""

    def __init__(self, settings: Settings, lesson: int) -> None:
        self.runners = [Runner(settings, lesson, worker) for worker in range(settings.workers)]

    def sample(self, policy: Policy, critic: nn.Module) -> tuple[Rollout, list[bool]]:
        return joined([runner.run(policy, critic) for runner in self.runners])


class Remote:
    """The same on a Ray cluster: each worker is an actor that holds its environments. One that is lost ends it all."""

    def __init__(self, ray, settings: Settings, lesson: int) -> None:
        actor = ray.remote(num_cpus=1)(Actor)
        self.ray, alone = ray, replace(settings, threads=1)
        self.actors = [actor.remote(alone, lesson, worker) for worker in range(settings.workers)]

    def sample(self, policy: Policy, critic: nn.Module) -> tuple[Rollout, list[bool]]:
        weights = self.ray.put([policy.state_dict(), critic.state_dict()])  # once for each node
        parts = self.ray.get([actor.run.remote(weights) for actor in self.actors])
        return joined([(Rollout(*columns), successes) for columns, successes in parts])


class Actor:
    """What a worker of the cluster holds: its runner, and copies of the networks."""

    def __init__(self, settings: Settings, lesson: int, worker: int) -> None:
        torch.set_num_threads(1)
        self.runner, self.networks = Runner(settings, lesson, worker), (Policy(), network(FEATURES + 1, 1))

    def run(self, weights: list[dict[str, torch.Tensor]]) -> tuple[tuple[torch.Tensor, ...], list[bool]]:
        for module, values in zip(self.networks, weights, strict=True):
            module.load_state_dict(values)
        rollout, successes = self.runner.run(*self.networks)
        return tuple(rollout), successes


def joined(parts: list[tuple[Rollout, list[bool]]]) -> tuple[Rollout, list[bool]]:
    """The shares of all workers next to one another, in their order."""
    rollouts, successes = zip(*parts, strict=True)
    columns = (torch.cat(column, dim=1) for column in zip(*rollouts, strict=True))
    return Rollout(*columns), [won for some in successes for won in some]


def advantages(rollout: Rollout, settings: Settings) -> torch.Tensor:
    """Generalised advantages, from the last step to the first. What lies beyond a time limit is the critic's guess."""
    result, following = torch.zeros_like(rollout.rewards), torch.zeros_like(rollout.rewards[0])
    for t in reversed(range(len(result))):
        ahead = rollout.values[t + 1] * ~rollout.terminated[t]
        reward = settings.reward_scale * (rollout.rewards[t] - settings.haste)
        surprise = reward + settings.discount * ahead - rollout.values[t]
        following = surprise + settings.discount * settings.trace * following * ~rollout.ended[t]
        result[t] = following
    return result


def update(policy: Policy, critic: nn.Module, optimizer, rollout: Rollout, left: float, settings: Settings) -> None:
    """Some epochs over a rollout; `left` is the share of the training that lies ahead."""
    optimizer.param_groups[0]["lr"] = settings.learning_rate * left
    gains = advantages(rollout, settings)
    returns = (gains + rollout.values[:-1])[rollout.valid]
    gains = (gains - gains[rollout.valid].mean()) / (gains[rollout.valid].std() + 1e-8)
    kept = [gains, rollout.seen, rollout.way_left, rollout.choices, rollout.log_probs]
    gains, seen, way_left, choices, log_probs = (column[rollout.valid] for column in kept)

    for _ in range(settings.epochs):
        for some in torch.randperm(len(seen)).chunk(settings.minibatches):
            now = policy.logits(seen[some]).log_softmax(1)
            ratio = (now.gather(1, choices[some, None]).squeeze(1) - log_probs[some]).exp()
            clipped = ratio.clamp(1.0 - settings.clip, 1.0 + settings.clip)
            policy_loss = -torch.min(ratio * gains[some], clipped * gains[some]).mean()
            value_loss = (worth(critic, seen[some], way_left[some]) - returns[some]).square().mean()
            entropy = -(now.exp() * now).sum(1).mean()
            optimizer.zero_grad()
            (policy_loss + 0.5 * value_loss - left * settings.entropy * entropy).backward()
            nn.utils.clip_grad_norm_(optimizer.param_groups[0]["params"], 0.5)
            optimizer.step()


def train(settings: Settings, sampling: Callable = Local) -> tuple[Policy, list[dict]]:
    """The policy, and how it went: a point for each update."""
    if settings.num_envs % settings.workers:
        raise ValueError(f"{settings.num_envs} environments are no whole number for each of {settings.workers} workers")
    wall, cpu = time.perf_counter(), time.process_time()
    torch.manual_seed(settings.seed)
    torch.set_num_threads(1)  # a second one waits more than it works
    policy, critic = Policy(), network(FEATURES + 1, 1)
    optimizer = torch.optim.Adam([*policy.parameters(), *critic.parameters()], eps=1e-5, fused=True)
    curve, total = [], sum(updates for _, _, updates in settings.lessons)
    for lesson, (_, _, updates) in enumerate(settings.lessons):
        sampler = sampling(settings, lesson)
        for _ in range(updates):
            rollout, won = sampler.sample(policy, critic)
            update(policy, critic, optimizer, rollout, 1.0 - len(curve) / total, settings)
            point = {
                "steps": (len(curve) + 1) * settings.rollout * settings.num_envs,
                "wall_s": round(time.perf_counter() - wall, 2),
                "cpu_s": round(time.process_time() - cpu, 2),
                "episodes": len(won),
                "success": float(np.mean(won)) if won else None,
            }
            curve.append(point)
            if len(curve) % 10 == 0 or len(curve) == total:
                print(point, flush=True)
    return policy, curve


def classroom(noise: str, scenes: int, seed: int, num_envs: int, settings: Settings) -> VectorEnv:
    """Places from sparse to crowded, and robots in them, behind the collision monitor as they will be."""
    difficulties = np.linspace(0.2, 1.0, scenes).tolist()
    places = [Scene.generate(seed + i, difficulty=difficulty) for i, difficulty in enumerate(difficulties)]
    several = {"num_envs": num_envs, "num_threads": settings.threads, "copy": False}
    lesson = {"noise": noise, "randomization": settings.randomization, "max_steps": settings.max_steps}
    return VectorEnv(scene=places, episodes="reactive", **lesson, **several, **DRIVING)


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
    driver, scenes = Driver(policy, settings.seed), dict.fromkeys(episode.scene for episode in episodes)
    outcomes = evaluate(driver, episodes, gate=gate, max_steps=300, num_threads=settings.threads, **DRIVING)
    won = {scene: [out.success for out in outcomes if out.episode.scene == scene] for scene in scenes}
    shares = {scene: float(np.mean(successes)) for scene, successes in won.items()}
    print(f'gate="{gate}":', {scene: f"{share:.0%}" for scene, share in shares.items()}, flush=True)
    return shares


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
    memory = dict(zip(("grid", "ways"), nothing_yet(goal), strict=True))
    inputs = {"lidar": torch.ones(2, BEAMS), "goal": goal, **memory, "chance": torch.full((2, CHOICES), 0.5)}
    outputs = ("action", *(f"next_{name}" for name in memory))
    axes = {name: {0: "robots"} for name in (*inputs, *outputs)}
    names = {"input_names": [*inputs], "output_names": [*outputs], "dynamic_axes": axes, "opset_version": 17}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of what this exporter says about itself: the new one needs another package
        torch.onnx.export(policy.eval(), tuple(inputs.values()), path, **names, dynamo=False)


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--save", type=Path, help="path without suffix")
    arguments.add_argument("--untrained", action="store_true", help="drive with what is set by hand alone")
    arguments.add_argument("--workers", type=int, default=1, help="that share the environments")
    arguments.add_argument("--engine", choices=("local", "ray"), default="local", help="where they drive")
    arguments.add_argument("--address", help="of the Ray cluster; one is started here without")
    arguments.add_argument("--quick", action="store_true", help="too short to learn much")
    given = arguments.parse_args()
    settings = Settings(seed=given.seed, workers=given.workers)
    if given.quick:
        settings.num_envs, settings.lessons = 32, (("ideal", 2, 2), ("realistic", 1, 1))
    with ExitStack() as stack:
        on_ray = given.engine == "ray" and not given.untrained
        sampling = partial(Remote, stack.enter_context(cluster(given.address))) if on_ray else Local
        policy, curve = (Policy.untrained(), []) if given.untrained else train(settings, sampling)
    episodes = load_episodes("reactive_v1")["episodes"][:: 50 if given.quick else 1]
    success = {gate: success_by_scene(policy, settings, episodes, gate=gate) for gate in ("full", "limits")}
    if given.save:
        save_weights(policy, given.save.with_suffix(".safetensors"))
        export_onnx(policy, given.save.with_suffix(".onnx"))
        report = {"settings": asdict(settings), "success": success, "curve": curve}
        given.save.with_suffix(".json").write_text(json.dumps(report))


if __name__ == "__main__":
    main()
