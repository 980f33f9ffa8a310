"""Environments: alone and in a batch the same to the bit, and millions of random steps within their spaces."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threewe import Scene, sync
from threewe.benchmark import Episode, load_episodes
from threewe.gym import TASKS, Env, VectorEnv
from threewe.gym.batch import TASK_FIELDS

from verify.cases.no_sonar_profile import no_sonar_profile
from verify.cases.soak import soak
from verify.harness import Case, Experiment, all_of, each, info, known_miss, mean_of, share_of

EPISODES = 50  # of one case of agreement
AROUND_ROBOTS = 20  # episodes of one case of agreement between the native form and that around a robot
BEAMS = 72


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


def agree_with_robot(seed: int, task: str) -> dict[str, Any]:
    """Random episodes in the native form and around a robot that knows the truth."""
    with no_sonar_profile() as hardware:
        return compare_with_robot(seed, task, hardware)


def compare_with_robot(seed: int, task: str, hardware: Path) -> dict[str, Any]:
    rng = np.random.default_rng(seed)
    options: dict[str, Any] = {
        "task": task,
        "scene": [Scene.generate(int(rng.integers(1, 2**31))), "apartment_v1", "dynamic_v1"],
        "observations": ("lidar", "pose", "velocity", *TASK_FIELDS[task]),
        "noise": str(rng.choice(["realistic", "ideal"])),
        "localization": "truth",
        "hardware": hardware,
        "max_steps": 60,
    }
    native, robot = Env(**options), Env(backend="mock", **options)
    different = 0
    for episode in range(AROUND_ROBOTS):
        given = {"seed": int(rng.integers(2**40))} if episode % 4 == 0 else {}
        ours, theirs = robot.reset(**given), native.reset(**given)
        equal, over = equal_bits(ours, theirs), False
        for step in itertools.count():
            if step % 5 == 0:
                action = rng.uniform(-1.2, 1.2, 3).astype(np.float32)
            ours, theirs = robot.step(action), native.step(action)
            equal = equal and equal_bits(ours, theirs)
            over = theirs[2] or theirs[3]
            if over or not equal:
                break
        different += not equal
        if not over:  # where they part their episodes need not end together
            break
    return {"different": different}


def equal_bits(ours: Any, theirs: Any) -> bool:
    """Whether two observations, or tuples and dicts of more, are the same."""
    if isinstance(theirs, tuple):
        return len(ours) == len(theirs) and all(map(equal_bits, ours, theirs))
    if isinstance(theirs, dict):
        return ours.keys() == theirs.keys() and all(equal_bits(ours[name], theirs[name]) for name in theirs)
    return bool(ours.tobytes() == theirs.tobytes() if isinstance(theirs, np.ndarray) else ours == theirs)


def follow_gaps(observation: dict[str, NDArray[Any]]) -> NDArray[np.float32]:
    """A policy without memory: towards the goal, by the direction in which the robot has most room to go there."""
    lidar = observation["lidar"].astype(np.float64)
    ranges = np.where(lidar > 0.0, lidar, 12.0)
    angles = np.linspace(-np.pi, np.pi, BEAMS, endpoint=False)
    apart = angles[:, None] - angles[None, :]
    ahead, aside = ranges * np.cos(apart), np.abs(ranges * np.sin(apart))
    free = np.where((ahead > 0.0) & (aside < 0.2), ahead - 0.2, 12.0).min(axis=1).clip(0.0, 1.2)
    goal = observation["goal"].astype(np.float64)
    bearing, distance = np.arctan2(goal[1], goal[0]), np.hypot(*goal)
    score = free.clip(0.0, distance) * (1.2 + np.cos(angles - bearing))
    best = int(score.argmax())
    speed = min(1.0, 0.2 + free[best])
    return np.array([speed * np.cos(angles[best]), speed * np.sin(angles[best]), 0.5 * np.sin(bearing)], np.float32)


def drive_env(env: Env, episode: Episode) -> dict[str, Any]:
    """An episode of an environment, by that policy."""
    place = {"scene": episode.scene, "start": episode.start, "goal": episode.goal}
    observation, info = env.reset(seed=episode.seed, options=place)
    way, actions = [info["true_pose"].tolist()], []
    over = False
    while not over:
        actions.append(follow_gaps(observation))
        observation, _, terminated, truncated, info = env.step(actions[-1])
        way.append(info["true_pose"].tolist())
        over = terminated or truncated
    return {"success": info["success"], "way": way}


def drive_robot(robot: sync.Robot, episode: Episode, steps: int) -> list[list[float]]:
    """The same by a program: what the policy sees is read off the robot, and what it answers is executed there."""
    truth = robot.simulation
    assert truth is not None
    truth.reset(seed=episode.seed, pose=episode.start)
    goal = truth.start_pose().inverse().transform(episode.goal)
    way = [[*truth.true_pose()]]
    for _ in range(steps):
        lidar = robot.get_lidar_scan().ranges[:: 360 // BEAMS]
        seen = np.array(robot.get_pose().inverse().transform(goal), np.float32)
        robot.execute_action(follow_gaps({"lidar": lidar, "goal": seen}), period=0.1)
        way.append([*truth.true_pose()])
    return way


def run_policy(seed: int) -> dict[str, Any]:
    """One policy, one episode: native and through a robot with the truth; and with the robot's own localization."""
    rng = np.random.default_rng(seed)
    episode = load_episodes("reactive_v1")["episodes"][int(rng.integers(700))]
    scene = episode.scene
    noise = str(rng.choice(["realistic", "ideal"]))
    options: dict[str, Any] = {
        "task": "navigation",
        "scene": scene,
        "noise": noise,
        "observations": ("lidar", "goal"),
        "lidar_beams": BEAMS,
        "max_steps": 400,
    }
    with no_sonar_profile() as hardware:
        native = drive_env(Env(localization="truth", hardware=hardware, **options), episode)
        with sync.Robot(scene=scene, noise=noise, localization="truth", hardware=hardware) as robot:
            driven = drive_robot(robot, episode, len(native["way"]) - 1)
    own = drive_env(Env(backend="mock", **options), episode)
    apart = np.hypot(*(np.array(own["way"][-1]) - native["way"][-1])[:2])
    return {
        "equal": driven == native["way"],
        "truth": native["success"],
        "own": own["success"],
        "alike": native["success"] == own["success"],
        "apart": float(apart),
    }


def arrivals(cases: list[Case]) -> str:
    """How often the policy arrives where poses are true, and where the robot finds out by itself."""
    truth, own = (sum(case[who] for case in cases) for who in ("truth", "own"))
    return f"{truth}/{len(cases)} with the truth, {own}/{len(cases)} with its own localization"


def distances(cases: list[Case]) -> str:
    """How far apart episodes end."""
    median, most, worst = np.quantile(np.array([case["apart"] for case in cases]), (0.5, 0.95, 1.0))
    return f"{median:.3f} m the median, {most:.3f} m of 95 %, {worst:.3f} m the worst of {len(cases)}"


EXPERIMENTS = [
    *(
        Experiment(
            name,
            run,
            variants=[{"task": task} for task in TASKS.values()],
            cases=cases * len(TASKS),
            rows=[equal, *each("task", TASKS.values(), lambda _, row=equal: row)],
        )
        for name, run, cases, equal in [
            (
                "alone and in a batch",
                agree,
                1000 // EPISODES,
                all_of(f"cases of {EPISODES} episodes, equal to the bit", lambda case: case["different"] == 0),
            ),
            (
                "around a robot that knows the truth",
                agree_with_robot,
                10,
                all_of(
                    f"cases of {AROUND_ROBOTS} episodes, the native form's bits", lambda case: not case["different"]
                ),
            ),
        ]
    ),
    Experiment(
        "a policy through Robot.execute_action",
        run_policy,
        cases=140,
        rows=[
            known_miss(
                all_of("with the truth its way in the native form, to the bit", lambda case: case["equal"]),
                139 / 140,
                "one of 140 robots slows for what seems to approach; where nothing moves, environments do not look",
            ),
            mean_of(
                "arrives with the truth more often than with its own localization, by",
                lambda case: float(case["truth"]) - float(case["own"]),
                form="{:.1%}",
                at_most=0.05,
            ),
            info("arrives", arrivals),
            share_of("by the autonomy stack it ends as with the truth", lambda case: case["alike"], at_least=0.9),
            share_of(
                "ends within 0.1 m of where it ends with the truth", lambda case: case["apart"] <= 0.1, at_least=0.5
            ),
            info("how far from there it ends", distances),
        ],
    ),
    *(
        Experiment(
            f"a million random steps a case, gate {gate}{', with assertions' * assertions}",
            soak,
            {"gate": gate, "assertions": assertions},
            cases=cases,
            limit=3600.0,
            rows=[
                all_of("a million steps, to the end", lambda case: case["steps"] >= 1_000_000),
                all_of("no NaN, nothing outside its space", lambda case: case["bad"] == 0),
                all_of("no robot leaves the world", lambda case: case["escaped"] == 0),
            ],
        )
        for gate, assertions, cases in (("limits", True, 90), ("full", True, 10), ("limits", False, 1))
    ),
]
