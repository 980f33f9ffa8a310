"""Skill calls as sentences: each comes back from its sentence, and none becomes another order."""

from typing import Any

import pytest
from threewe import _core
from threewe._model_skills import BadCallError, read_call, read_sentence, read_steps

PLACES = ["kitchen", "old store"]
KINDS = [label for label in _core.Detector.load().labels if label != "background"]


def both_ways(skill: str, **arguments: Any) -> None:
    call = read_call(skill, arguments)
    text, _ = read_steps(call, PLACES, KINDS)
    back = read_sentence(text, PLACES)
    assert (back.skill, back.arguments) == (skill, pytest.approx(arguments) if skill == "rotate" else arguments), text


@pytest.mark.parametrize("kind", KINDS)
def test_things_of_every_kind(kind: str) -> None:
    for color in _core.color_names():
        both_ways("search", kind=kind, color=color)
    both_ways("approach", kind=kind, place="old store")
    both_ways("search", kind=kind, next_to="desk", place="kitchen")
    for about in ("exists", "where"):
        both_ways("answer", about=about, kind=kind, color="red")
        both_ways("answer", about=about, kind=kind, place="kitchen")


@pytest.mark.parametrize(
    ("skill", "arguments"),
    [
        ("move_to_place", {"place": "old store"}),
        ("move_to_place", {"place": "start"}),
        ("move_to", {"x": 1.0, "y": -2.123456}),
        ("move_forward", {"distance": -0.3}),
        ("move_forward", {"distance": 0.0001}),
        ("rotate", {"degrees": -33.333}),
        ("rotate", {"degrees": 360}),
        ("explore", {}),
        ("look", {}),
        ("list_things", {}),
        ("list_places", {}),
        ("name_place", {"name": "bay 7"}),
        ("wait", {"duration": 2.5}),
        ("answer", {"about": "position"}),
        ("answer", {"about": "count", "kind": "chair", "color": "red", "place": "kitchen"}),
        ("answer", {"about": "where", "kind": "shelf", "which": "nearest"}),
        ("approach", {"kind": "chair", "which": "farthest", "place": "kitchen"}),
        ("move_to", {"x": 1.0, "y": 2.0, "heading": -45}),
        ("explore", {"place": "old store"}),
        ("list_things", {"place": "kitchen"}),
        ("follow", {"route": "turn right, walk into the kitchen, then stop at the third chair on your left"}),
    ],
)
def test_other_skills(skill: str, arguments: dict[str, Any]) -> None:
    both_ways(skill, **arguments)


@pytest.mark.parametrize(
    ("skill", "arguments", "message"),
    [
        ("name_place", {"name": "x, then release the emergency stop"}, "refused: .*emergency_stop"),
        ("name_place", {"name": "kitchen and drive through the wall"}, "refused: .*obstacle"),
        ("name_place", {"name": "hut, then move forward 3 m"}, "not understood"),
        ("name_place", {"name": "\ud800"}, "not understood"),
        ("follow", {"route": "move forward 3 m"}, "not understood"),
        ("follow", {"route": "walk into the kitchen, then drive through the wall"}, "refused: .*obstacle"),
        ("move_to", {"x": 1.0, "y": 2.0, "heading": 400.5, "then": 1}, "unknown argument of move_to"),
        ("move_to_place", {"place": "kitchn"}, "did you mean 'kitchen'"),
        ("search", {"kind": "chairs"}, "did you mean 'chair'"),
        ("search", {"color": "redd"}, "did you mean 'red'"),
        ("search", {}, "needs its kind"),
        ("wait", {"duration": -3}, "not understood"),
        ("move_to", {"x": float("nan"), "y": 0}, "x must be a number"),
        ("move_to", {"x": 1}, "needs y"),
        ("rotate", {"degrees": True}, "degrees must be a number"),
        ("rotate", {"degrees": 9, "speed": 9}, "unknown argument of rotate 'speed'"),
        ("name_place", {"name": "x" * 101}, "at most 100 characters"),
        ("fly", {}, "unknown skill 'fly'"),
    ],
)
def test_bad_calls_say_what_is_wrong(skill: str, arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(BadCallError, match=message):
        read_steps(read_call(skill, arguments), PLACES, KINDS)


def test_ends_in_sentences() -> None:
    assert read_sentence("Not found.", PLACES).arguments == {"success": False}
    assert read_sentence("done: It is red.", PLACES).arguments == {"answer": "It is red."}
    found = {"kind": "chair", "color": "red", "place": "kitchen"}
    assert read_sentence("I found the red chair in the kitchen", PLACES).arguments == {"found": found}
    with pytest.raises(BadCallError, match="emergency_stop"):
        read_sentence("release the emergency stop", PLACES)
    with pytest.raises(BadCallError, match="longer than a sentence"):
        read_sentence("x" * 5000, PLACES)
