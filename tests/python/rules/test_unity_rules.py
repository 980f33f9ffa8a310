"""Sources of a module that are compiled a few at a time mean what they mean alone.

There the anonymous namespace of one file is seen by others. So its names are no other file's, and none that a header
declares in the same or an outer namespace, where another file uses it; else CMakeLists.txt names the file ALONE.
"""

import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
WORD = re.compile(r"[A-Za-z_]\w*")
NO_DECLARATIONS = (
    "using namespace",
    "namespace",
    "return",
    "friend",
    "HWY",
    "static_assert",
    "public",
    "private",
    "extern",
    "else",
)


@dataclass
class Source:
    """What one file has in its anonymous namespaces, with the namespace around, and the words that it uses."""

    anonymous: set[tuple[str, str]] = field(default_factory=set)
    words: set[str] = field(default_factory=set)


def at_namespace_scope(text: str) -> Iterator[tuple[list[str], str]]:
    """Each line that begins at the margin, and the namespaces around it; an anonymous one is an empty name."""
    around: list[str] = []
    for line in text.splitlines():
        if match := re.match(r"(?:inline )?namespace ([\w:]*) ?\{", line):
            around.append(match[1])
        elif re.match(r"\}  // (inline )?namespace", line):
            around.pop()
        elif line and line[0] not in " }#/":
            yield around, line


def declared(line: str) -> str | None:
    """The name that a line declares."""
    line = re.sub(r"template <[^>]*>+ ?|\[\[\w+\]\] ", "", line)
    if match := re.match(r"(?:struct|class|enum class|enum|union|concept|using) (\w+)", line):
        return match[1]
    if line.startswith(NO_DECLARATIONS):
        return None
    words = WORD.findall(re.split(r"[=({;\[]", line, maxsplit=1)[0])
    return words[-1] if len(words) >= 2 else None


def read_source(text: str) -> Source:
    source = Source(words=set(WORD.findall(re.sub(r'//.*|"[^"\n]*"', "", text))))
    for around, line in at_namespace_scope(text):
        if "" in around and (name := declared(line)):
            source.anonymous.add(("::".join(filter(None, around)), name))
    return source


def read_header(text: str) -> set[tuple[str, str]]:
    lines = at_namespace_scope(text)
    return {("::".join(filter(None, around)), name) for around, line in lines if (name := declared(line))}


def leaks(sources: dict[str, Source], headers: set[tuple[str, str]]) -> list[str]:
    """Which file leaks which name into which others."""
    homes = defaultdict(set)
    for file, source in sources.items():
        for _, name in source.anonymous:
            homes[name].add(file)
    found = [f"{name} is in {' and '.join(sorted(files))}" for name, files in homes.items() if len(files) > 1]
    for file, source in sources.items():
        for space, name in source.anonymous:
            hidden = any(other == name and f"{space}::".startswith(f"{home}::") for home, other in headers)
            users = [other for other, one in sources.items() if other != file and name in one.words]
            if hidden and users:
                found.append(f"{name} of {file} hides that of a header from {', '.join(users)}")
    return sorted(found)


MODULES = re.findall(r"^threewe_module\((\S+)(.*)\)$", (ROOT / "CMakeLists.txt").read_text(), re.M)
HEADERS = {
    name
    for pattern in ("src/**/*.hpp", "include/**/*.hpp")
    for path in ROOT.glob(pattern)
    if not path.name.endswith("-inl.hpp")
    for name in read_header(path.read_text())
}


@pytest.mark.parametrize(("module", "options"), MODULES, ids=[name for name, _ in MODULES])
def test_no_name_leaks_into_another_source(module: str, options: str) -> None:
    nested = tuple(f"{name}/" for name, _ in MODULES if name.startswith(f"{module}/"))
    alone = (re.findall(r" ALONE ([\w ]+)", options) or [""])[0].split()
    sources = {}
    for path in (ROOT / "src" / module).rglob("*.cpp"):
        folder = path.parent.relative_to(ROOT / "src").as_posix()
        text = path.read_text()
        if not f"{folder}/".startswith(nested) and path.stem not in alone and "define HWY_TARGET_INCLUDE" not in text:
            sources[path.name] = read_source(text)
    assert leaks(sources, HEADERS) == []


def test_a_leak_is_found() -> None:
    plain = "namespace a::b {{\nnamespace {{\n{}\nint square({} x) {{\n}}\n}}  // namespace\n{}}}  // namespace a::b\n"
    first = plain.format("constexpr double kFast = 1.0;", "int", "")
    second = plain.format("", "double", "double f() { return kFast; }\n")
    sources = {"first.cpp": read_source(first), "second.cpp": read_source(second)}
    header = read_header("namespace a {\ninline constexpr double kFast = 20.0;\n}  // namespace a\n")
    assert leaks(sources, header) == [
        "kFast of first.cpp hides that of a header from second.cpp",
        "square is in first.cpp and second.cpp",
    ]
    elsewhere = read_header("namespace c {\ninline constexpr double kFast = 20.0;\n}  // namespace c\n")
    assert leaks(sources, elsewhere) == ["square is in first.cpp and second.cpp"]
