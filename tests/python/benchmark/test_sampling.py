"""Frozen sets of episodes are drawn as they say, and their files are read as they were written."""

from __future__ import annotations

import math
from collections import Counter
from itertools import islice
from pathlib import Path

import pytest
from threewe import ConfigError, Pose2D, RobotProfile, SceneTables
from threewe._core import ObjectNav
from threewe.benchmark import Episode, load_episodes
from threewe.benchmark.buildings import load_scene
from threewe.benchmark.episodes import to_json
from threewe.benchmark.sampling import (
    COLUMNS,
    EPISODES,
    IN_SIGHT,
    IN_SIGHT_SCENES,
    SCENES,
    SEEDS,
    SIGHTS,
    STRATA,
    draw_in_sight,
    draw_scene,
    generated_in_sight,
    make_episodes,
    scenes_of,
    splits_of,
    stratum_of,
    training_episodes,
)

SETS = [f"{task}_{split}_v1" for task in SCENES for split in splits_of(task)]


@pytest.mark.parametrize("name", SETS)
def test_sets_have_their_scenes_and_say_what_they_lack(name: str) -> None:
    episodes = load_episodes(name)
    task, split = episodes["task"], episodes["split"]
    counts = Counter(episode.scene for episode in episodes["episodes"])
    assert list(counts) == scenes_of(task, split)
    for scene in counts:
        assert (counts[scene] == EPISODES[task]) == (scene not in episodes["lacking"])
    assert (f"{task}_{split}_v1", SEEDS[split]) == (episodes["name"], episodes["seed"])
    assert len({(episode.scene, episode.index) for episode in episodes["episodes"]}) == len(episodes["episodes"])


@pytest.mark.parametrize("task", SCENES)
def test_files_are_written_as_they_are_read(task: str) -> None:
    name = f"{task}_val_v1"
    text = to_json(load_episodes(name), COLUMNS[task])
    assert text == next(Path(__file__).parents[3].glob(f"assets/episodes/{name}.json")).read_text()


@pytest.mark.parametrize("name", SETS)
def test_the_first_of_each_scene_are_drawn_again(name: str) -> None:
    frozen = load_episodes(name)
    scene = scenes_of(frozen["task"], frozen["split"])[1]  # the smallest
    listed = [episode for episode in frozen["episodes"] if episode.scene == scene]
    few = {"pointnav": 60, "objectnav": 12, "vln": 50, "exploration": 1}[frozen["task"]]
    attempts = 20 if frozen["task"] == "pointnav" else 4000
    drawn, _ = draw_scene(frozen["task"], scene, frozen["seed"], few, attempts=attempts)
    again = [episode for episode in listed if episode.index < attempts][:few]
    assert sorted(drawn, key=lambda e: e.index) == sorted(again, key=lambda e: e.index)


def test_strata_are_filled_equally_by_the_first_few_too() -> None:
    frozen = load_episodes("pointnav_val_v1")
    for scene in SCENES["pointnav"]:
        listed = [episode for episode in frozen["episodes"] if episode.scene == scene]
        full = [stratum for stratum in STRATA if stratum not in frozen["lacking"].get(scene, [])]
        first = Counter(episode.stratum for episode in listed[: 2 * len(STRATA)])
        assert all(first[stratum] >= 2 for stratum in full)
        assert all(Counter(episode.stratum for episode in listed)[stratum] == 10 for stratum in full)
        for episode in listed:
            assert episode.goal is not None
            assert episode.stratum == stratum_of(episode.geodesic, math.dist(episode.start[:2], episode.goal))
            assert episode.yardstick is not None
            assert episode.yardstick.success == 1.0


def test_no_search_is_for_a_door_or_next_to_its_goal() -> None:
    episodes = load_episodes("objectnav_test_v1")["episodes"]
    assert "door" not in {episode.category for episode in episodes}
    assert min(episode.geodesic for episode in episodes) >= 2.0


def test_training_goes_on_in_other_buildings_and_is_the_same_again() -> None:
    first = list(islice(training_episodes("objectnav", 3), 2))
    assert first == list(islice(training_episodes("objectnav", 3), 2))
    assert len({episode.scene for episode in first}) == 2
    assert first[0].scene != next(training_episodes("objectnav", 4)).scene
    episode: Episode = next(training_episodes("pointnav"))
    tables = SceneTables(load_scene(episode.scene), RobotProfile.load("3we_standard_v2"))
    assert tables.clearance(Pose2D(*episode.start)) >= 0.05


def test_held_out_buildings_need_their_secret_and_name_its_hash(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ConfigError, match="needs the secret"):
        make_episodes("objectnav", "generated")
    monkeypatch.setattr("threewe.benchmark.sampling.BUILDINGS", 1)
    made, other = (make_episodes("objectnav", "generated", secret=secret) for secret in ("one", "two"))
    assert made["commitment"] != other["commitment"]
    assert made["episodes"][0].scene != other["episodes"][0].scene
    assert "one" not in to_json(made, COLUMNS["objectnav"])


def test_unknown_tasks_and_splits_are_refused() -> None:
    with pytest.raises(ConfigError, match="did you mean 'pointnav'"):
        make_episodes("pointnaw", "val")
    with pytest.raises(ConfigError, match="did you mean 'val'"):
        make_episodes("pointnav", "vol")


def test_episodes_in_sight_are_drawn_again() -> None:
    frozen = load_episodes(IN_SIGHT)
    assert not frozen["lacking"]
    for scene in IN_SIGHT_SCENES:
        strata = Counter(episode.stratum for episode in frozen["episodes"] if episode.scene == scene)
        assert strata == dict.fromkeys(SIGHTS, 50)
    listed = [episode for episode in frozen["episodes"] if episode.scene == "apartment_v1"]
    assert draw_in_sight("apartment_v1", frozen["seed"], 16)[0] == listed[:16]
    text = to_json(frozen, COLUMNS[IN_SIGHT])
    assert text == next(Path(__file__).parents[3].glob(f"assets/episodes/{IN_SIGHT}.json")).read_text()


def test_episodes_in_sight_begin_where_the_camera_shows_the_kind() -> None:
    profile = RobotProfile.load("3we_standard_v2")
    for scene in ("apartment_v1", "outdoor_v1"):
        task = ObjectNav(SceneTables(load_scene(scene), profile), profile)
        for episode in load_episodes(IN_SIGHT)["episodes"]:
            if episode.scene == scene:
                kinds = set(task.in_sight(Pose2D(*episode.start)))
                assert episode.category in kinds
                assert bool(kinds - {episode.category, "door"}) == (episode.stratum == "among others")


def test_generated_buildings_have_episodes_in_sight() -> None:
    found = list(islice(generated_in_sight(7), 6))
    assert found == list(islice(generated_in_sight(7), 6))
    assert len({episode.scene for episode in found}) == 6
    assert {episode.scene for episode in found}.isdisjoint(e.scene for e in islice(generated_in_sight(8), 6))
    assert {episode.stratum for episode in found} <= set(SIGHTS)
