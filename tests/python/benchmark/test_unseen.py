"""Unseen scenes hold what nothing else does, and are frozen."""

from __future__ import annotations

import hashlib

import pytest
import threewe
from threewe import ConfigError, Scene
from threewe.benchmark.buildings import load_scene, scene_asset
from threewe.benchmark.unseen import HELD_OUT, OF, extent_of, replacement, unseen_scene

FROZEN = {
    "office_v2_unseen": "1d55127abdf668b823b1b375851980096e583614012659c254cbff2b46e0674d",
    "apartment_v1_unseen": "fda8a88895ffc99f71a339475981da2fdb27e587545b10b288bc8937c685a66d",
    "warehouse_v1_unseen": "c8474bd88e7f8b985b2999af30bbf3408e02d87a398a3cf7d05b6a6ae3aff1b5",
    "cluttered_v1_unseen": "ebaaf4c8809162c492205cb46f5318a7e64a93cc8cd40f701a644f215edcab8c",
}
"""SHA-256 of their text and of all prisms."""


def everything_in(scene: Scene) -> str:
    prisms = [
        (thing.name, prism.pose.x, prism.pose.y, prism.length, prism.width, prism.radius, prism.z_min, prism.z_max)
        for thing in scene.objects
        for prism in thing.prisms
    ]
    return scene.to_yaml(scene.name) + repr(prisms)


@pytest.mark.parametrize("name", FROZEN)
def test_they_are_as_they_were_when_they_were_published(name: str) -> None:
    assert hashlib.sha256(everything_in(load_scene(name)).encode()).hexdigest() == FROZEN[name]


@pytest.mark.parametrize("name", OF)
def test_all_but_the_furniture_is_as_it_was(name: str) -> None:
    scene, original = load_scene(f"{name}_unseen"), Scene.load(name)
    assert [thing.pose for thing in scene.objects] == [thing.pose for thing in original.objects]
    assert [thing.category for thing in scene.objects] == [thing.category for thing in original.objects]
    for thing, before in zip(scene.objects, original.objects, strict=True):
        held = HELD_OUT.get(thing.category)
        assert (thing.shape in held) if held else (thing.shape == before.shape)
    assert (scene.walls, scene.rooms) == (original.walls, original.rooms)


def test_held_out_shapes_stand_nowhere_else() -> None:
    scenes = [Scene.load(name) for name in threewe.scene_names()]
    buildings = [Scene.generate(seed, difficulty=0.9) for seed in range(30)]
    stand = {(thing.category, thing.shape) for scene in [*scenes, *buildings] for thing in scene.objects}
    assert not stand & {(category, shape) for category, shapes in HELD_OUT.items() for shape in shapes}
    unseen = {(thing.category, thing.shape) for name in OF for thing in load_scene(f"{name}_unseen").objects}
    missing = [(category, shape) for category, shapes in HELD_OUT.items() for shape in shapes
               if (category, shape) not in unseen]  # fmt: skip
    assert not missing


def test_they_fit_where_they_stand() -> None:
    assert replacement("chair", "tub", 0) != replacement("chair", "tub", 1), "alike ones take turns"
    assert replacement("shelf", "pallet_rack", 0) == "cantilever"
    assert replacement("shelf", "tower", 0) == "ladder"
    assert extent_of("chair", "shell") == pytest.approx((-0.21, -0.21, 0.21, 0.21), abs=0.003)


def test_other_scenes_have_none() -> None:
    with pytest.raises(ConfigError, match="did you mean 'office_v2_unseen'"):
        unseen_scene("office_v3_unseen")
    assert scene_asset("office_v2") == "office_v2"
