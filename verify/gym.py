"""Environments: alone and in a batch the same to the bit, and millions of random steps within their spaces."""

from __future__ import annotations

from typing import Any

import numpy as np
from threewe import Scene
from threewe.gym import TASKS, Env, VectorEnv
from threewe.gym.batch import TASK_FIELDS

from verify.harness import Experiment, all_of

EPISODES = 50  # of one case of agreement
ENVS = 1024
STEPS = 1000  # of each environment, in one case of random steps


def agree(seed: int, task: str) -> dict[str, Any]:
    """Random episodes, each in a batch at a random place, on 1, 2 or 4 threads, and alone."""
    rng = np.random.default_rng(seed)
    options: dict[str, Any] = {
        "task": task,
        "scene": [Scene.generate(int(rng.integers(1, 2**31))) for _ in range(2)],
        "observations": ("lidar", "pose", "velocity", *TASK_FIELDS[task]),
        "noise": str(rng.choice(["realistic", "ideal"])),
        "gate": str(rng.choice(["full", "limits"])),
        "localization": str(rng.choice(["noisy", "odometry", "truth"])),
        "randomization": str(rng.choice(["none", "paper", "hard"])),
        "max_steps": 60,
    }
    count = int(rng.integers(EPISODES, 2 * EPISODES))
    batch = VectorEnv(
        num_envs=count, num_threads=int(rng.choice([1, 2, 4])), autoreset_mode="Disabled", copy=True, **options
    )
    chosen = rng.choice(count, EPISODES, replace=False)
    first = int(rng.integers(2**40))
    actions = rng.uniform(-1.2, 1.2, (60, count, 3)).astype(np.float32)
    history = [batch.reset(seed=first)[0]]
    outcomes: list[Any] = [None]
    over = np.zeros(count, bool)
    for action in actions:
        observations, rewards, terminated, truncated, _ = batch.step(action)
        history.append(observations)
        outcomes.append((rewards, terminated, truncated))
        ended = terminated | truncated
        over |= ended
        if over.all():
            break
        if ended.any():  # who has ended goes on with another episode, which nobody looks at
            batch.reset(options={"reset_mask": ended})
    alone = Env(**options)
    different = sum(not same_alone(alone, first + int(i), int(i), actions, history, outcomes) for i in chosen)
    return {"different": different}


def same_alone(env: Env, seed: int, place: int, actions: Any, history: Any, outcomes: Any) -> bool:
    """Whether an episode alone is that of a place in the batch."""

    def same(observation: Any, then: int) -> bool:
        return all(np.array_equal(value, history[then][name][place]) for name, value in observation.items())

    observation, _ = env.reset(seed=seed)
    if not same(observation, 0):
        return False
    for then in range(1, len(history)):
        observation, reward, terminated, truncated, _ = env.step(actions[then - 1][place])
        rewards, ends, cuts = outcomes[then]
        if (reward, terminated, truncated) != (rewards[place], ends[place], cuts[place]):
            return False
        if terminated or truncated:  # what the batch shows next is of another episode
            return True
        if not same(observation, then):
            return False
    return True


def wander(seed: int, gate: str) -> dict[str, Any]:
    """A million random steps in a random scene, each observation held against its space."""
    rng = np.random.default_rng(seed)
    task = str(rng.choice(list(TASKS.values())))
    scene = Scene.generate(int(rng.integers(1, 2**31)), difficulty=float(rng.uniform()))
    env = VectorEnv(
        task=task,
        num_envs=ENVS,
        scene=scene,
        observations=("lidar", "pose", "velocity", *TASK_FIELDS[task]),
        gate=gate,
        randomization=str(rng.choice(["none", "mild", "paper", "hard"])),
        copy=False,
    )
    low, high = np.array(scene.min), np.array(scene.max)
    observations, _ = env.reset(seed=seed)
    bad = escaped = 0
    for step in range(STEPS):
        if step % 10 == 0:
            actions = rng.uniform(-1, 1, (ENVS, 3)).astype(np.float32)
        observations, rewards, _, _, _ = env.step(actions)
        for name, space in env.single_observation_space.spaces.items():  # type: ignore[attr-defined]
            values = observations[name]
            bad += int((~((values >= space.low) & (values <= space.high))).sum())
        bad += int((~np.isfinite(rewards)).sum())
        places = env.true_poses[:, :2]
        escaped += int(((places < low) | (places > high)).any(axis=1).sum())
    return {"bad": bad, "escaped": escaped}


EXPERIMENTS = [
    *(
        Experiment(
            f"alone and in a batch: {task}",
            agree,
            {"task": task},
            cases=1000 // EPISODES,
            sample=1,
            rows=[all_of(f"cases of {EPISODES} episodes, equal to the bit", lambda case: case["different"] == 0)],
        )
        for task in TASKS.values()
    ),
    *(
        Experiment(
            f"a million random steps a case, gate {gate}",
            wander,
            {"gate": gate},
            cases=cases,
            sample=sample,
            rows=[
                all_of("no NaN, nothing outside its space", lambda case: case["bad"] == 0),
                all_of("nobody leaves the world", lambda case: case["escaped"] == 0),
            ],
        )
        for gate, cases, sample in (("limits", 92, 1), ("full", 6, 0))
    ),
]
