"""Unseen scenes hold what nothing else does, and are frozen."""

from __future__ import annotations

import hashlib

import pytest
import threewe
from threewe import ConfigError, Scene
from threewe.benchmark.buildings import load_scene, scene_asset
from threewe.benchmark.unseen import HELD_OUT, OF, extent_of, replacement, unseen_scene

FROZEN = {
    "office_v2_unseen": "fc7df17f23a530a11d412300a5ce7ccfc15049a0cdc41a4264899ed5d206c2e3",
    "apartment_v1_unseen": "0eccebda677afae0c97a65efcb857784fa040a7fcdde8320a133bdcc9614db37",
    "warehouse_v1_unseen": "cf2a8bca3041a6616e2cce3811cf3ba78d89f7d68eea06fc086d7fce6a8d7f6a",
    "cluttered_v1_unseen": "b53cc49a97b2a98468a89550c3a488720f074631063836f75329b8233d218407",
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
