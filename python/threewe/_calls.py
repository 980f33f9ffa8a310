"""What was wrong with a call of the C++ core, in one sentence: which argument, what was given, what would be right."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from threewe.errors import ContractError

OPENING, CLOSING = "([{<", ")]}>"
NUMBERS = {"int", "bool"}  # what a float may be given as; an int may be given as numpy has integers, too
ARRAYS = {"ndarray", "numpy.ndarray"}
LISTS = {"list", "tuple", "range"} | ARRAYS


@dataclass(frozen=True)
class Parameter:
    """One parameter of a signature."""

    name: str
    type: str
    required: bool
    by_name_only: bool = False
    by_place_only: bool = False

    def might_take(self, given: str) -> bool:
        """False where a value of that type is never right."""
        return any(might_be(kind.strip(), given) for kind in split(self.type, "|"))


@dataclass(frozen=True)
class Signature:
    """How a function may be called."""

    name: str
    parameters: list[Parameter]

    def mistake(self, places: list[str], names: dict[str, str], not_text: str = "") -> Exception:
        """What is wrong with a call, given the types of its arguments and a string among them that is no UTF-8."""
        by_place = [p for p in self.parameters if not p.by_name_only]
        if len(places) > len(by_place):
            takes = f"takes {self._listed(by_place)} by place" if by_place else "takes no arguments by place"
            return TypeError(f"{self.name}() {takes}, got {len(places)} arguments")
        given = dict(zip((p.name for p in by_place), places, strict=False))
        by_name = {p.name for p in self.parameters if not p.by_place_only}
        for name, kind in names.items():
            if name not in by_name:
                return TypeError(f"{self.name}() has no argument '{name}'; it takes {self._listed(self.parameters)}")
            if name in given:
                return TypeError(f"{self.name}() got {name} twice")
            given[name] = kind
        if missing := [p for p in self.parameters if p.required and p.name not in given]:
            return TypeError(f"{self.name}() needs {self._listed(missing)}")
        return self._wrong_type(given, not_text)

    def _wrong_type(self, given: dict[str, str], not_text: str) -> Exception:
        passed = [p for p in self.parameters if p.name in given]
        for parameter in passed:
            if not parameter.might_take(given[parameter.name]):
                return self._error(parameter, f"got {in_words(given[parameter.name])}")
        strings = [p.name for p in passed if given[p.name] == "str"]
        if not_text and strings:
            return ContractError(
                f"{self.name}(): {' or '.join(strings)} must be text that UTF-8 can hold, got {not_text}"
            )
        # the type may be right, and what is in it is not: the first that can hold something wrong
        for parameter in passed:
            if given[parameter.name] in ARRAYS:
                return self._error(parameter, "and the array given differs in type or shape")
            if given[parameter.name] in LISTS:
                return self._error(parameter, f"and something in the {given[parameter.name]} given is none")
        for parameter in passed:
            if given[parameter.name] == "int":
                return self._error(parameter, "and the one given is negative or too large")
        return TypeError(f"{self.name}() was called with arguments that it does not take")

    def _error(self, parameter: Parameter, why: str) -> ContractError:
        return ContractError(f"{self.name}(): {parameter.name} must be {in_words(parameter.type)}, {why}")

    def _listed(self, parameters: list[Parameter]) -> str:
        return ", ".join(p.name for p in parameters) or "nothing"


def explain(text: str, not_text: str = "") -> Exception:
    """The error in place of nanobind's, whose text lists signatures and the types that were given."""
    head, _, rest = text.partition("(): incompatible function arguments.")
    listed, _, called = rest.partition("\nInvoked with types: ")
    places, names = given_types(called)
    lines = re.findall(r"^    \d+\. (.*)$", listed, re.MULTILINE)
    if head == "__init__":
        head = places[0].rpartition(".")[2]
    elif head == "__new__":
        head = lines[0].rpartition(".")[2]
    takes_self = lines[0].partition("(")[2].startswith("self")
    signatures = [read_signature(line, head) for line in lines]
    mistakes = [signature.mistake(places[takes_self:], names, not_text) for signature in signatures]
    return next((m for m in mistakes if isinstance(m, ContractError)), mistakes[0])


def read_signature(line: str, name: str) -> Signature:
    """Of a line such as `scale(self, by: float = 1.0, *, times: int) -> None`."""
    inside = line[line.index("(") + 1 : closing_bracket(line, line.index("("))]
    parameters: list[Parameter] = []
    by_name_only = False
    for piece in map(str.strip, split(inside, ",")):
        if piece in ("", "self"):
            continue
        if piece == "/":
            parameters = [Parameter(p.name, p.type, p.required, by_place_only=True) for p in parameters]
        elif piece.startswith("*"):
            by_name_only = True
        else:
            declared, default, _ = piece.partition(" = ")
            label, _, kind = declared.partition(":")
            parameters.append(Parameter(label.strip(), kind.strip(), not default, by_name_only))
    return Signature(name, parameters)


def given_types(called: str) -> tuple[list[str], dict[str, str]]:
    """The types of a call's arguments: by place, and by name."""
    by_place, _, by_name = called.strip().partition("kwargs = {")
    places = [piece.strip() for piece in split(by_place, ",") if piece.strip()]
    pairs = (piece.partition(":") for piece in split(by_name.rpartition("}")[0], ",") if piece.strip())
    return places, {name.strip(): kind.strip() for name, _, kind in pairs}


def might_be(wanted: str, given: str) -> bool:
    """False where a value of type `given` is never a `wanted`."""
    if wanted == given or wanted in ("object", "typing.Any"):
        return True
    if given.startswith("numpy.") and wanted in ("float", "int"):
        return given != "numpy.ndarray"
    if wanted == "float":
        return given in NUMBERS
    if wanted == "int":
        return given == "bool"
    if wanted.startswith(("collections.abc.Sequence", "tuple", "list", "ndarray", "numpy.ndarray")):
        return given in LISTS
    if wanted.startswith("collections.abc.Callable"):
        return given in ("function", "method", "builtin_function_or_method", "functools.partial")
    return False


def in_words(kind: str) -> str:
    """A type as a user would write it."""
    return " or ".join(one_in_words(part.strip()) for part in split(kind, "|"))


def one_in_words(kind: str) -> str:
    """A type that is no union."""
    words = {"str": "a string", "float": "a number", "int": "a whole number", "bool": "True or False"}
    if kind in words:
        return words[kind]
    if items := re.fullmatch(r"collections\.abc\.Sequence\[(.*)\]", kind):
        return f"a list of {one_in_words(items[1])}"
    if items := re.fullmatch(r"tuple\[(.*)\]", kind):
        return f"({items[1]})"
    if array := re.fullmatch(r"(?:numpy\.)?ndarray\[(.*)\]", kind):
        return array_in_words(array)
    return kind.rpartition(".")[2] if re.fullmatch(r"[\w.]+", kind) else kind


def array_in_words(match: re.Match[str]) -> str:
    """`numpy.ndarray[dtype=float32, shape=(*), ...]` as `a float32 array of shape (*)`."""
    dtype = re.search(r"dtype=(\w+)", match[1])
    shape = re.search(r"shape=(\([^)]*\))", match[1])
    kind = f"{dtype[1]} array" if dtype else "array"
    return f"{'an' if kind[0] in 'ai' else 'a'} {kind}{' of shape ' + shape[1] if shape else ''}"


def closing_bracket(text: str, opening: int) -> int:
    """Where the bracket is closed that is opened at `opening`."""
    depth = 0
    for at, character in brackets(text):
        if at >= opening:
            depth += 1 if character in OPENING else -1
            if depth == 0:
                return at
    return len(text)


def split(text: str, separator: str) -> list[str]:
    """Pieces between separators that are outside of all brackets and quotes."""
    depth, start, pieces = 0, 0, []
    for at, character in unquoted(text):
        if character in OPENING:
            depth += 1
        elif character in CLOSING:
            depth -= text[at - 1 : at + 1] != "->"
        elif character == separator and depth == 0:
            pieces.append(text[start:at])
            start = at + 1
    return [*pieces, text[start:]]


def brackets(text: str) -> Iterator[tuple[int, str]]:
    """Where brackets are, outside of quotes."""
    for at, character in unquoted(text):
        if character in OPENING or (character in CLOSING and text[at - 1 : at + 1] != "->"):
            yield at, character


def unquoted(text: str) -> Iterator[tuple[int, str]]:
    """The characters outside of quotes, and where each is."""
    quoted = ""
    for at, character in enumerate(text):
        if quoted:
            quoted = "" if character == quoted else quoted
        elif character in "'\"":
            quoted = character
        else:
            yield at, character
