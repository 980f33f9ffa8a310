"""Sampler of benchmark episodes: fixed splits, buildings without end, and held-out ones."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterator
from itertools import count, islice

from threewe import RobotProfile, SceneTables
from threewe._core import ObjectNav, Vln, nearest_frontier, optimistic_replanning, unknown_name
from threewe.benchmark.buildings import building_name, load_scene
from threewe.benchmark.episodes import FARTHEST, OPTIONAL, Episode, EpisodeSet, Yardstick
from threewe.benchmark.unseen import OF, SUFFIX
from threewe.errors import ConfigError

HARDWARE = "3we_standard_v2"
SCENES = {
    "pointnav": (
        "office_v2",
        "apartment_v1",
        "corridor_v1",
        "warehouse_v1",
        "cluttered_v1",
        "outdoor_v1",
        "dynamic_v1",
    ),
    "objectnav": ("office_v2", "apartment_v1", "warehouse_v1", "cluttered_v1"),
    "vln": ("office_v2", "apartment_v1", "corridor_v1", "warehouse_v1"),
    "exploration": ("office_v2", "apartment_v1", "corridor_v1"),
}
HELD_OUT = ("pointnav", "objectnav", "exploration")
"""Tasks with a split `generated`, whose hashes are published."""
SEEDS = {"val": 20_261_201, "test": 20_261_202, "unseen": 20_261_203}
IN_SIGHT = "in_sight_v1"
IN_SIGHT_SCENES = ("office_v2", "apartment_v1", "corridor_v1", "warehouse_v1", "cluttered_v1", "outdoor_v1")
IN_SIGHT_SEED = 20_261_125
SIGHTS = ("alone", "among others")
"""Strata of episodes in sight: whether another kind is in sight, too."""
VERSION = 1
EPISODES = {"pointnav": 60, "objectnav": 50, "vln": 50, "exploration": 20}  # in each scene
BUILDINGS = 100  # of the split `generated`
ATTEMPTS = 4000  # indices of the sampler; a stratum that is not full by then is lacking

LENGTHS = ((2.0, 5.0), (5.0, 9.0), (9.0, 15.0))  # [m] of the shortest path
DETOUR = 1.3  # times the straight line
STRATA = [f"{low:g}-{high:g} {way}" for low, high in LENGTHS for way in ("straight", "detour")]
SIGHT_TRIES = 60  # indices of the sampler for a category and a stratum
SHORTEST_SEARCH = 2.0  # [m] of ObjectNav: the sampler's shortest are next to success

COLUMNS = {
    "pointnav": ["index", "seed", "start", "goal", "geodesic", "stratum", "yardstick"],
    "objectnav": ["index", "seed", "start", "geodesic", "category"],
    "vln": ["index", "seed", "start", "goal", "geodesic", "instruction"],
    "exploration": ["index", "seed", "start", "yardstick"],
    IN_SIGHT: ["index", "seed", "start", "geodesic", "category", "stratum"],
}
Drawn = tuple[list[Episode], list[str]]
"""Episodes of a scene, and the strata or categories that it has too few of."""


def make_episodes(task: str, split: str, *, secret: str | None = None) -> EpisodeSet:
    """A fixed split, the same bytes on every machine. Takes minutes.

    `generated` needs a secret: its 100 buildings follow from it, and the set names its hash.
    """
    if task not in SCENES:
        raise ConfigError(unknown_name("task", task, list(SCENES)))
    if split == "generated" and task in HELD_OUT:
        return _generated(task, secret)
    if split not in splits_of(task):
        known = [*splits_of(task), *(["generated"] if task in HELD_OUT else [])]
        raise ConfigError(unknown_name(f"split of {task}", split, known))
    made = _empty(task, split, SEEDS[split])
    for scene in scenes_of(task, split):
        episodes, lacking = draw_scene(task, scene, SEEDS[split], EPISODES[task])
        made["episodes"] += episodes
        if lacking:
            made["lacking"][scene] = lacking
    return made


def splits_of(task: str) -> list[str]:
    """The fixed splits of a task: only what is looked for can be unseen."""
    return [split for split in SEEDS if split != "unseen" or task == "objectnav"]


def scenes_of(task: str, split: str) -> list[str]:
    """The scenes of a fixed split."""
    return [f"{scene}{SUFFIX}" for scene in OF] if split == "unseen" else list(SCENES[task])


def training_episodes(task: str, seed: int = 0) -> Iterator[Episode]:
    """The split `train`: one episode each in buildings without end, no two alike."""
    if task not in SCENES:
        raise ConfigError(unknown_name("task", task, list(SCENES)))
    return _in_buildings(task, f"train/{seed}", seed)


def draw_scene(task: str, scene: str, seed: int, episodes: int, *, attempts: int = ATTEMPTS, turn: int = 0) -> Drawn:
    """The episodes of one scene: a pure function of its arguments. `turn` is the stratum or category that is first."""
    profile = RobotProfile.load(HARDWARE)
    tables = SceneTables(load_scene(scene), profile)
    draws: dict[str, Callable[..., Drawn]] = {
        "pointnav": _pointnav,
        "objectnav": _objectnav,
        "vln": _vln,
        "exploration": _exploration,
    }
    return draws[task](scene, tables, profile, seed, episodes, attempts, turn)


def stratum_of(geodesic: float, straight: float) -> str | None:
    """Which stratum an episode belongs to, by length [m] and directness; none beyond all of them."""
    way = "detour" if geodesic > DETOUR * straight else "straight"
    for low, high in LENGTHS:
        if low <= geodesic < high:
            return f"{low:g}-{high:g} {way}"
    return None


def in_turns(names: list[str], first: int) -> list[str]:
    """The names, from that one on, and round to it again."""
    first %= max(len(names), 1)
    return names[first:] + names[:first]


def _pointnav(
    scene: str, tables: SceneTables, profile: RobotProfile, seed: int, episodes: int, attempts: int, turn: int
) -> Drawn:
    """The first indices that fill all strata equally; in turns, so that the first few are balanced too."""
    strata = in_turns(STRATA, turn)[:episodes]
    each = math.ceil(episodes / len(strata))
    filled: dict[str, list[Episode]] = {stratum: [] for stratum in strata}
    for index in range(attempts):
        drawn = tables.sample_episode(seed, index)
        stratum = stratum_of(drawn.geodesic, math.dist((drawn.start.x, drawn.start.y), drawn.goal))
        if stratum not in filled or len(filled[stratum]) == each:
            continue
        best = optimistic_replanning(tables, profile, drawn.start, drawn.goal)
        yardstick = Yardstick(float(best.reached), best.length, best.duration)
        start = (drawn.start.x, drawn.start.y, drawn.start.theta)
        goal = (drawn.goal[0], drawn.goal[1])
        filled[stratum].append(
            Episode(scene, index, drawn.seed, start, goal, drawn.geodesic, stratum=stratum, yardstick=yardstick)
        )
        if all(len(some) == each for some in filled.values()):
            break
    balanced = [some[i] for i in range(each) for some in filled.values() if i < len(some)]
    return balanced[:episodes], [stratum for stratum, some in filled.items() if len(some) < each]


def _objectnav(
    scene: str, tables: SceneTables, profile: RobotProfile, seed: int, episodes: int, attempts: int, turn: int
) -> Drawn:
    """The categories of the scene in turns, without doors, which are only trained on."""
    task = ObjectNav(tables, profile)
    categories = in_turns([category for category in task.goals if category != "door"], turn)
    found: list[Episode] = []
    for index in range(attempts):
        category = categories[len(found) % len(categories)]
        drawn = task.sample(seed, index, category)
        if drawn.geodesic < SHORTEST_SEARCH:
            continue
        start = (drawn.start.x, drawn.start.y, drawn.start.theta)
        found.append(Episode(scene, index, drawn.seed, start, None, drawn.geodesic, category=category))
        if len(found) == episodes:
            return found, []
    return found, categories[len(found) % len(categories) :]


def _vln(
    scene: str, tables: SceneTables, profile: RobotProfile, seed: int, episodes: int, attempts: int, turn: int
) -> Drawn:
    """Instructions are those of the sampler."""
    del profile, attempts, turn
    task = Vln(tables)
    found = []
    for index in range(episodes):
        drawn = task.sample(seed, index)
        start = (drawn.start.x, drawn.start.y, drawn.start.theta)
        found.append(Episode(scene, index, drawn.seed, start, drawn.end, drawn.geodesic, instruction=drawn.instruction))
    return found, []


def _exploration(
    scene: str, tables: SceneTables, profile: RobotProfile, seed: int, episodes: int, attempts: int, turn: int
) -> Drawn:
    """Starts are those of the sampler."""
    del attempts, turn
    found = []
    for index in range(episodes):
        drawn = tables.sample_episode(seed, index)
        best = nearest_frontier(tables, profile, drawn.start)
        start = (drawn.start.x, drawn.start.y, drawn.start.theta)
        yardstick = Yardstick(best.coverage, best.length, best.duration)
        found.append(Episode(scene, index, drawn.seed, start, None, 0.0, yardstick=yardstick))
    return found, []


def _generated(task: str, secret: str | None) -> EpisodeSet:
    if not secret:
        raise ConfigError("split 'generated' needs the secret that its buildings are drawn from")
    commitment = hashlib.sha256(secret.encode()).hexdigest()
    made = _empty(task, "generated", int(commitment[:8], 16))
    made["commitment"] = commitment
    made["episodes"] += islice(_in_buildings(task, secret, made["seed"]), BUILDINGS)
    return made


def _in_buildings(task: str, key: str, seed: int) -> Iterator[Episode]:
    for number in count():
        try:
            episodes, _ = draw_scene(task, building_name(f"{key}/{number}"), seed, 1, attempts=200, turn=number)
        except ConfigError:  # a building without any such episode
            continue
        yield from episodes


def _empty(task: str, split: str, seed: int) -> EpisodeSet:
    ranges = {"pointnav": (LENGTHS[0][0], LENGTHS[-1][1]), "objectnav": (SHORTEST_SEARCH, FARTHEST)}
    shortest, longest = ranges.get(task, (OPTIONAL["shortest"], OPTIONAL["longest"]))
    return {
        "name": f"{task}_{split}_v{VERSION}",
        "task": task,
        "split": split,
        "hardware": HARDWARE,
        "seed": seed,
        "shortest": shortest,
        "longest": longest,
        "straightness": FARTHEST,
        "lacking": {},
        "commitment": "",
        "episodes": [],
    }


def make_reactive() -> EpisodeSet:
    """The set `reactive_v1`: the first hundred in each scene that are 2 to 8 m long and nearly straight."""
    made = _empty("pointnav", "", 20_261_121)
    made.update({"name": "reactive_v1", "task": "navigation", "longest": 8.0, "straightness": DETOUR})
    profile = RobotProfile.load(HARDWARE)
    for scene in SCENES["pointnav"]:
        tables = SceneTables(load_scene(scene), profile)
        made["episodes"] += islice(_reactive(scene, tables, made), 100)
    return made


def _reactive(scene: str, tables: SceneTables, definition: EpisodeSet) -> Iterator[Episode]:
    for index in count():
        drawn = tables.sample_episode(definition["seed"], index)
        start, goal = drawn.start, (drawn.goal[0], drawn.goal[1])
        straight = ((goal[0] - start.x) ** 2 + (goal[1] - start.y) ** 2) ** 0.5
        if not definition["shortest"] <= drawn.geodesic <= definition["longest"]:
            continue
        if drawn.geodesic <= definition["straightness"] * straight:
            yield Episode(scene, index, drawn.seed, (start.x, start.y, start.theta), goal, drawn.geodesic)


def make_in_sight() -> EpisodeSet:
    """The set `in_sight_v1` of ObjectNav: something of the kind is in sight, a hundred in each static scene."""
    made = _empty("objectnav", "", IN_SIGHT_SEED)
    made.update({"name": IN_SIGHT, "shortest": OPTIONAL["shortest"]})
    for scene in IN_SIGHT_SCENES:
        episodes, lacking = draw_in_sight(scene, IN_SIGHT_SEED, 100)
        made["episodes"] += episodes
        if lacking:
            made["lacking"][scene] = lacking
    return made


def draw_in_sight(scene: str, seed: int, episodes: int, *, turn: int = 0) -> Drawn:
    """Episodes in sight of one scene, the strata alternating, the categories in turns but for doors.

    Categories are lacking of which nothing was found. A pure function of its arguments.
    """
    profile = RobotProfile.load(HARDWARE)
    task = ObjectNav(SceneTables(load_scene(scene), profile), profile)
    categories = in_turns([category for category in task.goals if category != "door"], turn)
    found: list[Episode] = []
    lacking = set(categories)
    first = 0
    for turns in count():
        if len(found) == episodes or first >= ATTEMPTS or not categories:
            break
        category = categories[(turns + turns // len(categories)) % len(categories)]
        for index in range(first, first + SIGHT_TRIES):
            first = index + 1
            try:
                drawn = task.sample_in_sight(seed, index, category)
            except ConfigError:  # nothing of it can be seen
                break
            others = set(task.in_sight(drawn.start)) - {category, "door"}
            stratum = SIGHTS[bool(others)]
            if stratum == SIGHTS[(len(found) + turn) % len(SIGHTS)]:
                start = (drawn.start.x, drawn.start.y, drawn.start.theta)
                found.append(
                    Episode(scene, index, drawn.seed, start, None, drawn.geodesic, category=category, stratum=stratum)
                )
                lacking.discard(category)
                break
    return found, sorted(lacking)


def generated_in_sight(seed: int | str) -> Iterator[Episode]:
    """Episodes in sight in generated buildings without end, one in each; each stratum and category is as likely."""
    for number in count():
        try:
            name = building_name(f"in_sight/{seed}/{number}")
            drawn = int(name.removeprefix("building-"))
            yield from draw_in_sight(name, drawn, 1, turn=drawn)[0]
        except ConfigError:  # a building in which nothing can be looked for
            continue


def make_named(name: str, *, secret: str | None = None) -> tuple[EpisodeSet, list[str]]:
    """A set by its name, such as `pointnav_val_v1`, and the columns of its file."""
    if name == "reactive_v1":
        return make_reactive(), list(OPTIONAL["columns"])
    if name == IN_SIGHT:
        return make_in_sight(), COLUMNS[IN_SIGHT]
    task, _, rest = name.partition("_")
    split = rest.removesuffix(f"_v{VERSION}")
    sets = [(task, split) for task in SCENES for split in splits_of(task)]
    sets += [(task, "generated") for task in HELD_OUT]
    known = ["reactive_v1", IN_SIGHT, *(f"{task}_{split}_v{VERSION}" for task, split in sets)]
    if name not in known:
        raise ConfigError(unknown_name("set of episodes", name, known))
    return make_episodes(task, split, secret=secret), COLUMNS[task]
