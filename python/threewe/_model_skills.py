"""The list of skills, as a model of language calls them: one schema, and a sentence of the grammar for each call."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from threewe import _core
from threewe.language import Step, encodable, read_command

LONGEST = 100  # [characters] of a name
LONGEST_ANSWER = 1000
LARGEST = 1000.0  # of a number, whatever its unit
ANGLES = {"degrees": "angle", "heading": "theta"}
"""Arguments in degrees, and the fields of a Step that hold them in radians."""

Properties = dict[str, dict[str, Any]]

_text = {"type": "string"}
_number = {"type": "number"}
_kind = {"type": "string", "description": "kind of thing, such as chair"}
_color = {"type": "string", "description": "such as red"}
_place = {"type": "string", "description": "a known place"}
_thing: Properties = {
    "kind": _kind,
    "color": _color,
    "which": {"type": "string", "enum": ["nearest", "farthest"]},
    "next_to": {"type": "string", "description": "another thing"},
    "place": _place,
}
_about = {"type": "string", "enum": ["exists", "where", "count", "position"]}
_degrees = {"type": "number", "description": "[degrees], counter-clockwise"}

Skills = Mapping[str, tuple[str, Properties, tuple[str, ...]]]
"""What each does, its arguments, and which of them are needed, by their names."""
SKILLS: Skills = {
    "move_to_place": ("drive to a known place", {"place": _place}, ("place",)),
    "approach": ("drive to a thing", _thing, ()),
    "search": ("look for a thing until the robot stands before it", _thing, ()),
    "move_to": (
        "drive to x, y [m] of the map, and turn to a heading where one is given",
        {"x": _number, "y": _number, "heading": _degrees},
        ("x", "y"),
    ),
    "move_forward": ("drive straight on [m], backwards where negative", {"distance": _number}, ("distance",)),
    "rotate": ("turn on the spot", {"degrees": _degrees}, ("degrees",)),
    "follow": (
        "follow a route through rooms whose borders are known, as a person tells it",
        {"route": {"type": "string", "description": "such as: go into the hall, then stop at the second chair"}},
        ("route",),
    ),
    "explore": ("map what is unknown; with a place, drive there", {"place": _place}, ()),
    "look": ("turn once around to see", {}, ()),
    "list_things": ("say which things are known, in a place after a look there", {"place": _place}, ()),
    "list_places": ("say which places are known", {}, ()),
    "name_place": ("give the place where the robot is a name", {"name": _text}, ("name",)),
    "wait": ("stand for some seconds", {"duration": _number}, ("duration",)),
    "answer": (
        "let the robot find out itself, about a thing or its own position",
        {"about": _about, **_thing},
        ("about",),
    ),
    "done": (
        "end: the instruction is done or, with success false, cannot be",
        {
            "success": {"type": "boolean"},
            "answer": {"type": "string", "description": "what to say to the user"},
            "found": {"type": "object", "properties": _thing, "description": "the thing that was found"},
        },
        (),
    ),
}


class BadCallError(Exception):
    """What a model answered is no call of a skill; the text says what would be one."""


@dataclass(frozen=True)
class Call:
    """A skill and its arguments, checked by the schema."""

    skill: str
    arguments: dict[str, Any]

    def __str__(self) -> str:
        said = ", ".join(f"{name}={value}" for name, value in self.arguments.items())
        return f"{self.skill}({said})"


def tools(skills: Skills = SKILLS) -> list[dict[str, Any]]:
    """The skills as tools of chat completions."""
    return [
        {
            "type": "function",
            "function": {"name": name, "description": about, "parameters": object_schema(properties, needed)},
        }
        for name, (about, properties, needed) in skills.items()
    ]


def schema(skills: Skills = SKILLS) -> dict[str, Any]:
    """One object for all of them: `skill`, and the arguments of any."""
    properties: Properties = {"skill": {"type": "string", "enum": list(skills)}}
    for _, arguments, _ in skills.values():
        for name, of in arguments.items():
            if properties.setdefault(name, of) != of:
                properties[name] = {}  # of different types in two skills: checked by the robot alone
    return object_schema(properties, ("skill",))


def object_schema(properties: Properties, needed: Sequence[str]) -> dict[str, Any]:
    return {"type": "object", "properties": properties, "required": list(needed), "additionalProperties": False}


def parsed(text: str) -> dict[str, Any]:
    """The object that a text is, in JSON. Raises BadCallError."""
    try:
        value = json.loads(text, parse_constant=lambda _: math.nan)
    except (ValueError, RecursionError):
        raise BadCallError("that is no JSON object") from None
    if not isinstance(value, dict):
        raise BadCallError("that is no JSON object")
    return value


def read_call(skill: object, arguments: Mapping[str, object], skills: Skills = SKILLS) -> Call:
    """Checks a call by the schema. Raises BadCallError."""
    if not isinstance(skill, str) or skill not in skills:
        raise BadCallError(_core.unknown_name("skill", short(skill), list(skills)))
    _, properties, needed = skills[skill]
    given = {name: value for name, value in arguments.items() if value is not None and value != ""}
    for name, value in given.items():
        if name not in properties:
            raise BadCallError(_core.unknown_name(f"argument of {skill}", short(name), list(properties)))
        _check(f"{skill}: {name}", value, properties[name])
    missing = [name for name in needed if name not in given]
    if missing:
        raise BadCallError(f"{skill} needs {' and '.join(missing)}")
    return Call(skill, given)


def _check(what: str, value: object, of: Mapping[str, Any]) -> None:
    """Raises BadCallError unless a value is as its schema says."""
    kind = of["type"]
    if kind in ("number", "integer"):
        good = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST  # no NaN
        if not good or (kind == "integer" and not isinstance(value, int)):
            whole = "whole " if kind == "integer" else ""
            raise BadCallError(f"{what} must be a {whole}number of at most {LARGEST:g}, got {short(value)}")
    elif kind == "boolean":
        if not isinstance(value, bool):
            raise BadCallError(f"{what} must be true or false, got {short(value)}")
    elif kind == "object":
        if not isinstance(value, dict):
            raise BadCallError(f"{what} must be an object with kind and color, got {short(value)}")
        for name, part in value.items():
            if name not in of["properties"]:
                raise BadCallError(_core.unknown_name(f"argument of {what}", short(name), list(of["properties"])))
            if part is not None:
                _check(f"{what}.{name}", part, of["properties"][name])
    else:
        longest = LONGEST_ANSWER if what.endswith(" answer") else LONGEST
        if not isinstance(value, str) or len(value) > longest:
            raise BadCallError(f"{what} must be a text of at most {longest} characters, got {short(value)}")
        if "enum" in of and value not in of["enum"]:
            raise BadCallError(f"{what} must be one of {', '.join(of['enum'])}, got {short(value)}")


def short(value: object) -> str:
    text = str(value) if isinstance(value, str | int | float | bool) else type(value).__name__
    return encodable(text if len(text) <= 40 else text[:37] + "...")


def sentence(call: Call) -> str:
    """A call in words of the grammar; `done` in words of `read_sentence`."""
    a = call.arguments
    match call.skill:
        case "move_to_place":
            return f"go to the {a['place']}"
        case "approach":
            return f"go to the {_in_words(a)}"
        case "search":
            return f"find the {_in_words(a)}"
        case "move_to":
            facing = f" facing {_plain(a['heading'])} degrees" if "heading" in a else ""
            return f"go to ({_plain(a['x'])}, {_plain(a['y'])}){facing}"
        case "move_forward":
            return f"move {'forward' if a['distance'] >= 0 else 'backward'} {_plain(abs(a['distance']))} m"
        case "rotate":
            return f"turn {'left' if a['degrees'] >= 0 else 'right'} {_plain(abs(a['degrees']))} degrees"
        case "look":
            return "look around"
        case "list_things":
            return f"list things in the {a['place']}" if "place" in a else "list things"
        case "explore":
            return f"explore the {a['place']}" if "place" in a else "explore"
        case "follow":
            return str(a["route"])
        case "list_places":
            return "list places"
        case "name_place":
            return f"call this place {a['name']}"
        case "wait":
            return f"wait {_plain(a['duration'])} seconds"
        case "answer":
            if a["about"] == "position":
                return "where are you?"
            if a["about"] == "count":
                return f"count the {_in_words(a)}"
            return f"is there a {_in_words(a)}?" if a["about"] == "exists" else f"where is the {_in_words(a)}?"
        case "done":
            if a.get("success") is False:
                return "not found"
            if found := a.get("found"):
                return f"found the {_in_words(found)}"
            return f"done: {a['answer']}" if "answer" in a else "done"
    return call.skill


def _in_words(thing: Mapping[str, Any]) -> str:
    if not thing.get("kind") and not thing.get("color"):
        raise BadCallError("a thing needs its kind, such as chair, or its color")
    parts = (thing.get("which"), thing.get("color"), thing.get("kind") or "thing")
    words = " ".join(part for part in parts if part)
    words += f" next to the {thing['next_to']}" if thing.get("next_to") else ""
    return words + (f" in the {thing['place']}" if thing.get("place") else "")


def _plain(number: float) -> str:
    return f"{number:.6f}".rstrip("0").rstrip(".")


def read_steps(call: Call, places: Sequence[str], kinds: Sequence[str]) -> tuple[str, int]:
    """The sentence that makes the offline agent do a call, and how many steps it has.

    Raises BadCallError where the grammar reads anything else out of it: no argument can become another order.
    """
    named = call.arguments.get("place")
    if named is not None and named != "start" and named not in places:
        raise BadCallError(_core.unknown_name("place", named, ["start", *places]))
    if (kind := call.arguments.get("kind")) is not None and kind not in kinds:
        raise BadCallError(_core.unknown_name("kind", kind, kinds))
    if (color := call.arguments.get("color")) is not None and color not in _core.color_names():
        raise BadCallError(_core.unknown_name("color", color, _core.color_names()))
    text = sentence(call)
    reading = read_command(text, places)
    if reading.rule is not None:
        raise BadCallError(f"refused: no instruction may override this: {reading.rule}")
    if not reading.steps or not _says(reading.steps[-1], call):
        raise BadCallError(f"{short(str(call))} is not understood: use names that are known")
    return text, len(reading.steps)


def _says(step: Step, call: Call) -> bool:
    """Whether a step is that call."""
    if step.skill.value != call.skill:
        return False
    for name, value in call.arguments.items():
        if name == "route":
            if _letters(step.route) != _letters(value):
                return False
            continue
        of_thing = ("kind", "color", "which", "next_to", *(["place"] if "kind" in SKILLS[call.skill][1] else []))
        if name in of_thing:
            read: Any = getattr(step.thing, name)
        else:
            read = getattr(step, ANGLES.get(name, name))
        wanted = math.radians(value) if name in ANGLES else value
        if isinstance(read, float):
            away = read - wanted
            if abs(math.remainder(away, math.tau) if name == "heading" else away) > 1e-5:
                return False
        elif read != wanted:
            return False
    return True


def _letters(text: str) -> list[str]:
    """Its words, in lower case."""
    return re.findall(r"\w+", text.lower())


def read_sentence(text: str, places: Sequence[str]) -> Call:
    """The call that a sentence of a model asks for: the first of its plan. Raises BadCallError."""
    said = text.strip().strip("\"'`*").strip()
    if re.fullmatch(r"(?i)(it was )?not found\W*", said):
        return Call("done", {"success": False})
    if match := re.fullmatch(r"(?is)done\s*:\s*(.+)", said):
        return read_call("done", {"answer": match[1][:LONGEST_ANSWER]})
    found = re.match(r"(?i)(i )?found ", said)
    if found:
        said = "find " + said[found.end() :]
    if len(said) > LONGEST_ANSWER:
        raise BadCallError("that is longer than a sentence")
    reading = read_command(said, places)
    if reading.rule is not None:
        raise BadCallError(f"refused: no instruction may override this: {reading.rule}")
    if not reading.steps:
        raise BadCallError(f"'{short(reading.word or said)}' is not understood: answer with one short command")
    call = _call_of(reading.steps[-1 if reading.steps[-1].skill.value in ("answer", "list_things") else 0])
    return Call("done", {"found": call.arguments}) if found and call.skill == "search" else call


def _call_of(step: Step) -> Call:
    values: dict[str, Any] = {}
    for name in SKILLS.get(step.skill.value, ("", {}, ()))[1]:
        value: Any = getattr(step, name, None) or getattr(step.thing, name, None)
        if name in ANGLES and (angle := getattr(step, ANGLES[name])) is not None:
            value = math.degrees(angle)
        if value is None and name in ("x", "y", "distance", "duration"):
            value = getattr(step, name)
        if value not in (None, ""):
            values[name] = value
    return read_call(step.skill.value, values)
