"""Skills that users add: typed coroutines, described to models by a schema and called by their names."""

from __future__ import annotations

import inspect
import json
import re
import types
import typing
from collections.abc import Awaitable, Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from threewe._core import ExploreResult, MoveResult
from threewe._model_skills import SKILLS, BadCallError, Call, Properties, Skills, object_schema, read_call
from threewe.errors import ContractError

if TYPE_CHECKING:
    from threewe.robot import Robot

NAME = re.compile(r"[a-z][a-z0-9_]{0,59}")
KINDS: dict[Any, str] = {str: "string", bool: "boolean", int: "integer", float: "number"}
TYPES = "str, int, float, bool or a Literal of texts"
CALL = re.compile(r"([a-z][a-z0-9_]*)\((.*)\)", re.DOTALL)
NEXT = re.compile(r"\s*(?:;|,\s*then\b|\bthen\b)\s*", re.IGNORECASE)

SkillFunction = Callable[..., Awaitable[Any]]


@dataclass(frozen=True)
class SkillInfo:
    """A skill, as models and programs may call it."""

    name: str
    """such as `search`"""
    description: str
    """what it does"""
    parameters: dict[str, Any]
    """its arguments, as a JSON schema of type `object`"""
    own: bool
    """added by `Robot.add_skill`"""


class UserSkills:
    """The skills that a user has added to a robot, besides those that all have."""

    def __init__(self) -> None:
        self._functions: dict[str, SkillFunction] = {}
        self.all: Skills = dict(SKILLS)

    def add(self, function: SkillFunction) -> None:
        """Raises ContractError for one that is not `async def name(robot, ...)`, with a docstring and types."""
        name = getattr(function, "__name__", "")
        if not inspect.iscoroutinefunction(function):
            raise ContractError(f"function must be an `async def` with the robot first, got {function!r}")
        if not NAME.fullmatch(name):
            raise ContractError(f"function must have a name in lower case, such as water_plant, got '{name}'")
        if name in self.all:
            raise ContractError(f"function: there is a skill '{name}' already: choose another name")
        about = " ".join((inspect.getdoc(function) or "").split("\n\n")[0].split())
        if not about:
            raise ContractError(f"function: skill '{name}' needs a docstring, by which models know what it does")
        properties, needed = _parameters(name, function)
        self._functions[name] = function
        self.all = {**self.all, name: (about, properties, needed)}

    def __contains__(self, name: object) -> bool:
        return name in self._functions

    def infos(self) -> list[SkillInfo]:
        """All of them, those that every robot has first."""
        return [
            SkillInfo(name, about, object_schema(properties, needed), name in self)
            for name, (about, properties, needed) in self.all.items()
            if name != "done"
        ]

    async def run(self, call: Call, robot: Robot) -> tuple[str, str, str]:
        """Reason, detail and answer. Whatever the function raises is its own; so is what it returns."""
        result = await self._functions[call.skill](robot, **call.arguments)
        if result is None:
            return "done", "", ""
        if isinstance(result, str):
            return "done", "", result
        if isinstance(result, MoveResult | ExploreResult):
            return "done" if result.success else str(result.reason), result.detail, ""
        raise ContractError(f"it must return None, a text or the result of a motion, got {type(result).__name__}")

    def read(self, text: str) -> Call | None:
        """The call of a user's skill that a text is, as "water(amount=2)" or "water"; None where it is none.

        Raises BadCallError for a call with wrong arguments.
        """
        said = text.strip().strip("\"'`*.!").strip()
        name = "_".join(said.lower().split())
        if name in self:
            return read_call(name, {}, self.all)
        match = CALL.fullmatch(said)
        if match is None or match[1] not in self:
            return None
        arguments: dict[str, Any] = {}
        for part in filter(None, (part.strip() for part in _split(match[2]))):
            argument, equals, value = part.partition("=")
            if not equals:
                raise BadCallError(
                    f"{match[1]}: arguments have names, as in {match[1]}({_example(self.all[match[1]])})"
                )
            arguments[argument.strip()] = _value(value.strip())
        return read_call(match[1], arguments, self.all)

    def parts(self, text: str) -> list[str | Call]:
        """The parts of an instruction in order: calls of users' skills, and what the grammar is to read."""
        parts: list[str | Call] = []
        for piece in NEXT.split(text) if self._functions else []:
            call = self.read(piece)
            if call is None and parts and isinstance(parts[-1], str):
                parts[-1] = f"{parts[-1]}, then {piece}"
            elif call is not None or piece:
                parts.append(call or piece)
        return parts if any(isinstance(part, Call) for part in parts) else [text]

    def in_words(self) -> Iterable[str]:
        """How each is called in a sentence."""
        return (f"{name}({_example(self.all[name])}): {self.all[name][0]}" for name in self._functions)


def _parameters(name: str, function: SkillFunction) -> tuple[Properties, tuple[str, ...]]:
    parameters = list(inspect.signature(function).parameters.values())
    if not parameters or parameters[0].name != "robot" or parameters[0].kind is not parameters[0].POSITIONAL_OR_KEYWORD:
        raise ContractError(f"function: the first parameter of skill '{name}' must be `robot`")
    try:
        hints = typing.get_type_hints(function)
    except NameError as error:
        # a type that is imported for checkers alone, as that of the robot may be, is no argument's
        hints = {key: value for key, value in function.__annotations__.items() if key != error.name}
    properties: Properties = {}
    for one in parameters[1:]:
        where = f"function: argument '{one.name}' of skill '{name}'"
        if one.kind in (one.VAR_POSITIONAL, one.VAR_KEYWORD, one.POSITIONAL_ONLY):
            raise ContractError(f"{where} must have a name of its own")
        if one.name in ("skill", "self"):
            raise ContractError(f"{where} must have another name")
        if one.name not in hints:
            raise ContractError(f"{where} needs a type: {TYPES}")
        kind = _schema(hints[one.name], optional=one.default is None)
        if kind is None:
            raise ContractError(f"{where} must be {TYPES}, got {_named(hints[one.name])}")
        properties[one.name] = kind
    return properties, tuple(one.name for one in parameters[1:] if one.default is one.empty)


def _schema(hint: Any, optional: bool) -> dict[str, Any] | None:
    """The schema of a type; None where a call of a model could not hold one."""
    if isinstance(hint, type) and hint in KINDS:
        return {"type": KINDS[hint]}
    of = typing.get_args(hint)
    if typing.get_origin(hint) is typing.Literal and of and all(isinstance(one, str) for one in of):
        return {"type": "string", "enum": list(of)}
    if typing.get_origin(hint) in (typing.Union, types.UnionType) and optional:
        kinds = [one for one in of if one is not types.NoneType]
        return _schema(kinds[0], False) if len(kinds) == 1 else None
    return None


def _named(hint: Any) -> str:
    return hint.__name__ if isinstance(hint, type) else str(hint)


def _example(skill: tuple[str, Properties, tuple[str, ...]]) -> str:
    return ", ".join(f"{name}={of['enum'][0] if 'enum' in of else of['type']}" for name, of in skill[1].items())


def _split(arguments: str) -> list[str]:
    """At commas outside of quotes."""
    return re.split(r""",(?=(?:[^"]*"[^"]*")*[^"]*$)""", arguments)


def _value(text: str) -> Any:
    """A number, true or false, or a text with or without quotes."""
    try:
        value = json.loads(text)
    except (ValueError, RecursionError):
        return text.strip("'")
    return value if isinstance(value, str | int | float | bool) else text
