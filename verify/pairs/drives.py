"""The fixed episodes: a few of every kind of task that drives, in all scenes and in generated buildings.

Their seeds are here for good: they are for comparison, and no published figure comes from them.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from threewe import OccupancyGrid, Pose2D, Robot, RobotProfile, Scene, SceneTables
from threewe.benchmark.attempt import Settings, attempt
from threewe.benchmark.sampling import IN_SIGHT_SCENES, SCENES, scenes_of
from threewe.gym.env import Env
from threewe.slam import accuracy, replay
from threewe.slam.synth import record, true_relations

from verify.cases import sensitivity
from verify.cases.benchmarks import episodes_of
from verify.cases.doorways import through_a_doorway
from verify.cases.driving import arrived, drive, drive_in_vain, drives_in_a_map, explore_together
from verify.cases.finding import find
from verify.cases.generated import drive_far, in_generated
from verify.cases.labyrinths import PLACES, mislead
from verify.cases.logs import SURVEYS
from verify.cases.routes import follow, go_to
from verify.cases.scaled import drive_in_sizes
from verify.cases.walls import away_from_a_wall, comes_to_its_goal, out_of_a_slot
from verify.pairs.outcomes import Outcome, logged, of_attempt, of_case, of_logs, outcome
from verify.pairs.policies import of_policy

STANDARD, TURTLEBOT, BASE = "3we_standard_v2", "turtlebot_like", "3we_base_v2"
ROBOTS = (STANDARD, TURTLEBOT)
SEED = 42_000_000
"""The first seed of what is drawn."""
ACTIONS = 300
"""Steps of an environment, ten a second."""
Success = Callable[[dict[str, Any]], bool]


@dataclass(frozen=True)
class Drive:
    """One fixed episode: a function that can be pickled, and its arguments."""

    name: str
    function: Callable[..., Outcome]
    arguments: dict[str, Any]


def numbered(
    name: str, count: int, case: Callable[..., dict[str, Any]], success: Success, /, **how: Any
) -> Iterator[Drive]:
    """Yields so many drives of one kind, whose seeds follow one another."""
    for k in range(count):
        yield Drive(f"{name}/{k}", of_case, {"function": case, "success": success, "seed": SEED + k, **how})


def pointnav() -> Iterator[Drive]:
    """Yields 50 frozen episodes in each of the seven scenes."""
    yield from frozen("pointnav", "navigator", SCENES["pointnav"], range(50))


def exploration() -> Iterator[Drive]:
    """Yields explorations: of frozen episodes, of buildings until they are done, of two robots."""
    yield from frozen("exploration", "navigator", SCENES["exploration"], range(2))
    yield from numbered("building", 4, sensitivity.exploration, covers, hardware=STANDARD)
    yield from numbered("two_robots", 1, explore_together, anyhow, scene="office_v2", strangers=True)


def search() -> Iterator[Drive]:
    """Yields searches for things: of ObjectNav, by instructions."""
    scenes = [*scenes_of("objectnav", "val"), *scenes_of("objectnav", "unseen")]
    yield from frozen("objectnav", "semantic", scenes, range(1))
    yield from numbered("find/office_v2", 1, find, finds, scene="office_v2")
    yield from numbered("find_colored/apartment_v1", 1, find, finds, scene="apartment_v1", colored=True)


def instructions() -> Iterator[Drive]:
    """Yields instructions along routes and to rooms."""
    for place in ("office_v2", "apartment_v1", "generated"):
        yield from numbered(f"follow/{place}", 1, follow, succeeds, place=place)
        yield from numbered(f"go_to/{place}", 1, go_to, succeeds, place=place)


def driving() -> Iterator[Drive]:
    """Yields drives of several robots: to far goals, through doors, away from walls, by sonar, in given maps."""
    for hardware in ROBOTS:
        for randomization in ("none", "hard"):
            how = {"run": drive_far, "hardware": hardware, "randomization": randomization}
            yield from numbered(f"far/{hardware}/{randomization}", 4, in_generated, arrived, **how)
        for place in ("hall", "corridor", "peopled"):
            how = {"run": drive_far, "hardware": hardware, "place": place}
            yield from numbered(f"far/{hardware}/{place}", 1, in_generated, arrived, **how)
        for spare, success in ((0.1, arrived), (0.07, arrived), (-0.01, no_path)):
            name = f"doorway/{hardware}/{1000 * spare:g}_mm"
            yield from numbered(name, 2, through_a_doorway, success, hardware=hardware, spare=spare)
        for place in PLACES:
            yield from numbered(f"{place}/{hardware}", 1, mislead, arrived, place=place, hardware=hardware)
        yield from numbered(f"slot/{hardware}", 2, out_of_a_slot, comes_to_its_goal, hardware=hardware)
        yield from numbered(f"scaled/{hardware}", 1, drive_in_sizes, all_arrive, hardware=hardware, scales=[0.5, 3.0])
    for hardware in (*ROBOTS, BASE):
        yield from numbered(f"wall/{hardware}", 2, away_from_a_wall, comes_to_its_goal, hardware=hardware)
    yield from numbered(f"sonar/{BASE}", 4, drive, arrived, scene="office_v2", hardware=BASE)
    yield from numbered("in_vain", 2, drive_in_vain, no_path, scene="office_v2", hardware=STANDARD)
    for scene in ("office_v2", "warehouse_v1"):
        yield from numbered(f"given_map/{scene}", 1, drives_in_a_map, all_arrive, scene=scene, drives=4)


def localization() -> Iterator[Drive]:
    """Yields logs that are mapped, and robots that must find out where they are."""
    for survey in SURVEYS:
        yield Drive(f"log/{survey}", map_a_log, {"survey": survey, "seed": SEED})
    yield from numbered("kidnapped", 4, sensitivity.kidnapped, comes_to_its_goal, hardware=STANDARD)
    for scene in ("office_v2", "apartment_v1", "corridor_v1"):
        yield Drive(f"anywhere/{scene}", find_itself, {"scene": scene, "seed": SEED})


def policies() -> Iterator[Drive]:
    """Yields episodes of the shipped policy."""
    for scene in IN_SIGHT_SCENES:
        for index in range(2):
            yield Drive(f"goto_v1/{scene}/{index}", of_policy, {"scene": scene, "index": index})


def environments() -> Iterator[Drive]:
    """Yields episodes of learning environments by drawn actions, among them some with pictures and hard noise."""
    for task in ("navigation", "exploration", "object_nav", "vln"):
        for scene in ("office_v2", "dynamic_v1") if task == "navigation" else ("office_v2", "apartment_v1"):
            for randomization in ("none", "hard"):
                arguments = {"task": task, "scene": scene, "randomization": randomization, "seed": SEED}
                yield Drive(f"{task}/{scene}/{randomization}", act, arguments)


SETS: dict[str, Callable[[], Iterator[Drive]]] = {
    "pointnav": pointnav,
    "driving": driving,
    "exploration": exploration,
    "search": search,
    "instructions": instructions,
    "localization": localization,
    "policies": policies,
    "environments": environments,
}


def frozen(task: str, agent: str, scenes: list[str], indices: range) -> Iterator[Drive]:
    """Yields the first frozen episodes of a benchmark in each scene."""
    for scene in scenes:
        for index in indices:
            arguments = {"task": task, "agent": agent, "scene": scene, "index": index}
            yield Drive(f"{task}/{scene}/{index}", of_episode, arguments)


def of_episode(task: str, agent: str, scene: str, index: int) -> Outcome:
    """Returns the outcome of a frozen episode, driven by a shipped agent."""
    return of_attempt(attempt(task, episodes_of(task, scene)[index], agent, Settings()))


def act(task: str, scene: str, randomization: str, seed: int) -> Outcome:
    """Returns the outcome of drawn actions in an environment; all that it observes is hashed."""
    draw = np.random.default_rng(seed)
    env = Env(task=task, scene=scene, randomization=randomization)
    seen: list[bytes] = []
    rewards = 0.0
    ends = 0
    observation, _ = env.reset(seed=seed)
    for _ in range(ACTIONS):
        action = np.clip(draw.normal([0.5, 0.0, 0.0], 0.5), -1.0, 1.0).astype(np.float32)
        observation, reward, terminated, truncated, _ = env.step(action)
        fields = observation.values() if isinstance(observation, dict) else [observation]
        seen += [np.asarray(field).tobytes() for field in fields]
        rewards += float(reward)
        if terminated or truncated:
            ends += 1
            env.reset()
    return outcome(f"{ends} ends, reward {rewards:.3f}", True, 0.1 * ACTIONS, 0.0, *seen)


def map_a_log(survey: str, seed: int) -> Outcome:
    """Returns the outcome of a log that is mapped: success is an error as small as claimed."""
    log, truth = record(survey, seed)
    result = replay(log)
    error = accuracy(result.trajectory, true_relations(truth)).translation[0]
    hashed = (result.trajectory.tobytes(), repr(result.events).encode())
    return outcome(f"{len(result.events)} events", error <= SURVEYS[survey], log.seconds, log.distance, *hashed)


def find_itself(scene: str, seed: int) -> Outcome:
    """Returns the outcome of robots that are put anywhere into a given map, and drive from there to one goal."""
    tables = SceneTables(Scene.load(scene), RobotProfile.load(STANDARD))
    goal = tables.sample_free_pose(seed)

    async def draw_map() -> OccupancyGrid:
        async with Robot(scene=scene, seed=seed) as robot:
            await robot.explore()
            return robot.get_map()

    async def go(grid: OccupancyGrid, start: Pose2D) -> str:
        async with Robot(scene=scene, map=grid, seed=seed, start_pose=start) as robot:
            await robot.sleep(2.0)
            result = await robot.move_to(goal.x, goal.y)
            return result.reason.name

    with logged() as logs:
        grid = asyncio.run(draw_map())
        reasons = [asyncio.run(go(grid, tables.sample_free_pose(seed + k))) for k in (1, 2, 3)]
    ends = [log.poses[-1] for log in logs[1:]]
    there = [math.hypot(x - goal.x, y - goal.y) <= 0.25 for x, y, _ in ends]
    return of_logs(" ".join(reasons), all(there), logs)


def anyhow(case: dict[str, Any]) -> bool:
    """Nothing is asked."""
    return bool(case)


def covers(case: dict[str, Any]) -> bool:
    """An exploration saw nearly all."""
    return bool(case["coverage"] >= 0.95)


def finds(case: dict[str, Any]) -> bool:
    """A search ended at the right thing."""
    return bool(case["found"])


def succeeds(case: dict[str, Any]) -> bool:
    """The instruction was followed."""
    return bool(case["success"])


def no_path(case: dict[str, Any]) -> bool:
    """The robot says that there is none."""
    return bool(case["reason"] == "no_path")


def all_arrive(case: dict[str, Any]) -> bool:
    """Each of several drives arrives."""
    return all(arrived(one) for one in case["drives"])
