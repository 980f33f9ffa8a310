"""Commands from Python: what comes back, what is refused, and the handwritten corpus."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import pytest
from threewe.errors import ContractError
from threewe.language import Reading, ReadingOutcome, RefusalRule, Skill, read_command

from verify.cases.handwritten_commands import PARTS, corpus, read_handwritten

PLACES = ["kitchen", "office 1", "office 2"]


def test_a_plan_has_steps_with_arguments() -> None:
    reading = read_command("Find the nearest red chair in the kitchen, then go to (2, 1) facing 90 degrees.", PLACES)
    assert reading.outcome == ReadingOutcome.understood == "understood"
    assert [step.skill for step in reading.steps] == [Skill.search, Skill.move_to] == ["search", "move_to"]
    search, move = reading.steps
    assert search.thing.kind == "chair"
    assert list(search.arguments.items()) == [
        ("kind", "chair"),
        ("color", "red"),
        ("which", "nearest"),
        ("place", "kitchen"),
    ]
    assert (move.x, move.y, move.distance) == (2.0, 1.0, None)
    assert move.theta == pytest.approx(1.5707963)
    assert str(move) == "move_to(x=2, y=1, theta=1.5708)"
    assert str(reading) == f"{search}; {move}"
    assert (reading.meanings, reading.word, reading.rule) == ([], "", None)


def test_other_outcomes_say_why() -> None:
    ambiguous = read_command("go to the office", PLACES)
    assert (ambiguous.outcome, ambiguous.meanings) == ("ambiguous", ["office 1", "office 2"])
    unknown = read_command("go to the garage")
    assert (unknown.outcome, unknown.word, unknown.steps) == ("not_understood", "garage", [])
    refused = read_command("drive through the wall")
    assert (refused.outcome, refused.rule) == ("refused", RefusalRule.obstacle)
    assert repr(refused) == "Reading(refused(obstacle))"


def test_readings_are_values() -> None:
    reading = read_command("go to the kitchen and wait 5 s", PLACES)
    assert isinstance(reading, Reading)
    for again in (copy.deepcopy(reading), pickle.loads(pickle.dumps(reading))):
        assert again == reading
        assert hash(again) == hash(reading)
    assert reading != read_command("go to the kitchen", PLACES)


def test_places_may_come_from_any_iterable() -> None:
    assert str(read_command("go to Büro 3", iter(["Büro 3"]))) == "move_to_place(place=Büro 3)"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((1,), "text must be a string, got 1"),
        ((None,), "text must be a string, got None"),
        (("go", "kitchen"), "places must be a list, got 'kitchen'"),
        (("go", [1]), r"places\[0\] must be a string, got 1"),
        (("go", ["kitchen", ""]), r"places\[1\]: expected a name of 1 to 200 bytes"),
        (("go", ["a\nb"]), r"places\[0\]: expected a name"),
        (("x" * 1001,), "text: expected at most 1000 characters, got 1001"),
        (("x" * 1_000_000,), "text: expected at most 1000 characters, got 1000000"),
    ],
)
def test_wrong_arguments_are_one_error(arguments: tuple[Any, ...], message: str) -> None:
    with pytest.raises(ContractError, match=message):
        read_command(*arguments)


@pytest.mark.parametrize("text", ["", "\x00", "\ud800 go", "去厨房", "🤖", " \n\t", "ق" * 1000, "(" * 1000])
def test_strange_texts_are_not_understood(text: str) -> None:
    assert read_command(text, PLACES).outcome == "not_understood"


def test_the_handwritten_commands_are_read_as_they_were_meant() -> None:
    parts = [read_handwritten(0, part) for part in range(PARTS)]
    count = sum(part["commands"] for part in parts)
    assert count == len(corpus()[1]) == 400
    assert sum(part["right"] for part in parts) >= 0.95 * count, [line for part in parts for line in part["lost"]]
    assert sum(part["wrong_plan"] for part in parts) <= 0.02 * count
