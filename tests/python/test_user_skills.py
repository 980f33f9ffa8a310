"""One list of skills: what every robot has, what users add, and who may call them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import pytest
from threewe import ContractError, EmergencyStopError, Robot, SafetyError, sync
from threewe._core import MoveResult
from threewe._model_skills import SKILLS
from threewe.language import Skill
from threewe.testing import ModelServer

DIALECTS = ["openai", "lmstudio", "transformers"]  # tools, a schema, sentences


async def say_hello(
    robot: Robot, name: str, times: int = 1, loud: bool = False, tone: Literal["low", "high"] | None = None
) -> str:
    """Says hello.

    To whoever is there.
    """
    assert robot.now > 0.0
    return " ".join([f"Hello {name}!"] * times) + (" LOUD" if loud else "") + (f" {tone}" if tone else "")


async def nudge(robot: Robot, distance: float = 0.2) -> MoveResult:
    """Drives a little ahead."""
    return await robot.move_forward(distance)


def test_the_list_is_that_of_the_offline_interpreter() -> None:
    assert sorted(SKILLS) == sorted(skill.value for skill in Skill)
    with sync.Robot() as robot:
        robot.add_skill(say_hello)
        infos = {info.name: info for info in robot.get_skills()}
    assert sorted(infos) == sorted([*SKILLS.keys() - {"done"}, "say_hello"])
    assert [name for name, info in infos.items() if info.own] == ["say_hello"]
    assert infos["say_hello"].description == "Says hello."
    assert infos["say_hello"].parameters == {
        "type": "object",
        "properties": {
            "name": {"type": "string"},
            "times": {"type": "integer"},
            "loud": {"type": "boolean"},
            "tone": {"type": "string", "enum": ["low", "high"]},
        },
        "required": ["name"],
        "additionalProperties": False,
    }
    assert infos["follow"].parameters["required"] == ["route"]


def test_programs_call_skills_by_name() -> None:
    with sync.Robot() as robot:
        robot.add_skill(say_hello)
        result = robot.execute_skill("say_hello", name="Ada", times=2, loud=True, tone="low")
        assert (result.success, result.answer, result.verified) == (True, "Hello Ada! Hello Ada! LOUD low", False)
        assert [(step.skill, step.reason) for step in result.steps] == [("say_hello", "done")]
        turned = robot.execute_skill("rotate", degrees=30)
        assert (turned.success, turned.steps[0].text) == (True, "rotate(angle=0.5236)")
        there = robot.execute_skill("move_to", x=0.4, y=0.0, heading=90)
        assert there.success
        assert abs(robot.get_pose().theta - 1.5708) < 0.2
        assert robot.execute_skill("answer", about="position").answer.startswith("I am at")
        for skill, arguments, says in [
            ("say_helo", {}, "unknown skill 'say_helo'.*say_hello"),
            ("say_hello", {}, "say_hello needs name"),
            ("say_hello", {"name": 7}, "name must be a text"),
            ("say_hello", {"name": "A", "times": 1.5}, "times must be a whole number"),
            ("say_hello", {"name": "A", "tone": "flat"}, "tone must be one of low, high"),
            ("say_hello", {"name": "A", "volume": 1}, "unknown argument of say_hello 'volume'"),
            ("move_to_place", {"place": "moon"}, "unknown place 'moon'"),
            ("done", {}, "none of programs"),
        ]:
            with pytest.raises(ContractError, match=says):
                robot.execute_skill(skill, **arguments)


def test_sentences_call_skills_by_name() -> None:
    with sync.Robot() as robot:
        robot.add_skill(nudge)
        robot.add_skill(say_hello)
        result = robot.execute_instruction('Turn left 20 degrees, then nudge; say_hello(name="Bo, or Bea", times=1)')
        assert (result.success, result.answer) == (True, "Hello Bo, or Bea!")
        assert [step.skill for step in result.steps] == ["rotate", "nudge", "say_hello"]
        assert result.distance == pytest.approx(0.2, abs=0.05)
        assert robot.execute_instruction("Nudge.").steps[0].text == "nudge()"
        lost = robot.execute_instruction("nudge, then frobnicate the widget")
        assert (lost.reason, lost.steps) == ("not_understood", ())
        for text, says in [("say hello", "say_hello needs name"), ("say_hello(Bo)", "arguments have names")]:
            wrong = robot.execute_instruction(text)
            assert wrong.reason == "not_understood"
            assert says in wrong.detail
        assert robot.execute_instruction("nudge, then nudge, then nudge", max_steps=2).reason == "budget"


@pytest.mark.parametrize("dialect", DIALECTS)
def test_models_call_skills_by_name(dialect: str) -> None:
    said = {"skill": "say_hello", "name": "Cy", "times": 2}
    answers: list[Any] = [said, {"skill": "say_hello", "name": 3}, {"skill": "done"}]
    if dialect == "transformers":
        answers[:2] = ["say_hello(name=Cy, times=2)", "say_hello(times=x)"]
    with ModelServer(answers, dialect=dialect) as server, sync.Robot() as robot:
        robot.add_skill(say_hello)
        result = robot.execute_instruction("greet Cy", model=server.url, thinking_time=0.0)
        assert (result.reason, result.answer, result.verified) == ("done", "Hello Cy! Hello Cy!", False)
        assert [step.reason for step in result.steps] == ["done", "not_understood"]
        assert "say_hello" in str(server.requests[-1])
        assert "Says hello" in str(server.requests[-1])


def wrong() -> list[tuple[Any, str]]:
    def plain(robot: Robot) -> None:
        """Does nothing."""

    async def undocumented(robot: Robot) -> None:
        pass

    async def alone() -> None:
        """Takes nothing."""

    async def untyped(robot: Robot, amount) -> None:  # type: ignore[no-untyped-def]
        """Takes anything."""

    async def listed(robot: Robot, amounts: list[str]) -> None:
        """Takes a list."""

    async def many(robot: Robot, *amounts: int) -> None:
        """Takes many."""

    async def named(robot: Robot, skill: str) -> None:
        """Takes a reserved name."""

    async def mixed(robot: Robot, amount: int | str) -> None:
        """Takes one of two types."""

    async def search(robot: Robot) -> None:
        """Looks elsewhere."""

    async def Shout(robot: Robot) -> None:  # noqa: N802
        """Shouts."""

    return [
        (plain, "must be an `async def`"),
        (7, "must be a function, got 7"),
        (undocumented, "'undocumented' needs a docstring"),
        (alone, "the first parameter of skill 'alone' must be `robot`"),
        (untyped, "argument 'amount' of skill 'untyped' needs a type: str, int"),
        (listed, r"argument 'amounts' of skill 'listed' must be str, int.* got list\[str\]"),
        (many, "argument 'amounts' of skill 'many' must have a name of its own"),
        (named, "argument 'skill' of skill 'named' must have another name"),
        (mixed, "argument 'amount' of skill 'mixed' must be"),
        (search, "there is a skill 'search' already"),
        (Shout, "a name in lower case"),
    ]


def test_what_is_no_skill_is_one_error() -> None:
    with sync.Robot() as robot:
        for function, says in wrong():
            with pytest.raises(ContractError, match=says):
                robot.add_skill(function)
        robot.add_skill(nudge)
        with pytest.raises(ContractError, match="there is a skill 'nudge' already"):
            robot.add_skill(nudge)
        assert [info.name for info in robot.get_skills() if info.own] == ["nudge"]


def failing(robot: sync.Robot) -> list[tuple[Callable[..., Any], str, str]]:
    async def breaks(robot: Robot) -> None:
        """Fails."""
        robot.set_velocity(0.2, hold=5.0)
        raise ValueError("no water")

    async def nests(robot: Robot) -> None:
        """Asks for another."""
        await robot.execute_skill("look")

    async def forgets(robot: Robot) -> None:
        """Stops by itself."""
        robot.emergency_stop()
        await robot.move_forward(0.1)

    async def returns_much(robot: Robot) -> Any:
        """Returns what is none."""
        return robot.get_map()

    async def lasts(robot: Robot) -> None:
        """Takes its time."""
        await robot.sleep(1e6)

    async def hurries(robot: Robot) -> MoveResult:
        """Has no time."""
        return await robot.move_forward(1.0, timeout=0.5)

    del robot
    return [
        (breaks, "skill_error", "breaks: ValueError: no water"),
        (nests, "skill_error", "nests: SafetyError: an instruction is being executed"),
        (forgets, "estop", "the emergency stop is latched"),
        (returns_much, "skill_error", "must return None, a text or the result of a motion, got OccupancyGrid"),
        (lasts, "budget", "lasts took more than 40 s"),
        (hurries, "timeout", ""),
    ]


def test_a_skill_that_fails_ends_with_one_reason_and_the_robot_stands() -> None:
    with sync.Robot() as robot:
        for function, reason, says in failing(robot):
            robot.add_skill(function)
            result = robot.execute_instruction(function.__name__, timeout=40.0)
            assert (result.success, result.reason) == (False, reason)
            assert says in result.detail
            assert len(result.steps) == 1
            robot.release_emergency_stop()
            robot.sleep(1.0)
            assert abs(robot.get_velocity().vx) < 0.05
            assert robot.execute_instruction("turn left 10 degrees").success
        robot.emergency_stop()
        with pytest.raises(EmergencyStopError):
            robot.execute_skill("lasts")


async def test_one_instruction_at_a_time() -> None:
    async with Robot() as robot:

        @robot.add_skill
        async def asks(robot: Robot) -> str:
            """Asks while it runs."""
            with pytest.raises(SafetyError):
                await robot.execute_instruction("look around")
            with pytest.raises(SafetyError):
                await robot.execute_skill("asks")
            return "refused"

        assert (await robot.execute_skill("asks")).answer == "refused"
