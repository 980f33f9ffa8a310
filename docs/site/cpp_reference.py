"""The C++ reference: Doxygen's XML as a page per module, each with its headers, classes and functions in their order.

Doxygen's own pages do not fit a telephone's screen, and have a page per class besides lists of all that is on them;
here what belongs together is on one page, and found by the site's search.
"""

import html
import itertools
import re
import shutil
import subprocess
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from xml.etree import ElementTree as ET

ROOT = Path(__file__).resolve().parents[2]
INCLUDE = ROOT / "include"
XML = ROOT / "build" / "doxygen" / "xml"
COMPARISON = re.compile(r"operator[=!]=")  # which does what everyone expects
SHOWN = ("function", "variable", "typedef", "enum")


def modules() -> list[str]:
    """The folders of include/threewe that have public headers."""
    return sorted({path.parent.relative_to(INCLUDE / "threewe").parts[0] for path in headers()})


def headers() -> list[Path]:
    """Public headers, without the one that includes the others."""
    return sorted(path for path in (INCLUDE / "threewe").glob("*/**/*.hpp") if not path.name.endswith("-inl.hpp"))


def run_doxygen() -> list[str]:
    """Writes build/doxygen/xml; what is wrong with the comments of classes and their members."""
    log = XML.parent / "warnings.txt"
    shutil.rmtree(log.parent, ignore_errors=True)  # else pages of headers that are gone would stay
    log.parent.mkdir(parents=True)
    subprocess.run(["doxygen", "docs/site/Doxyfile"], cwd=ROOT, check=True)
    lines = log.read_text().replace(f"{ROOT}/", "").splitlines()
    return [line for line in lines if line and not COMPARISON.search(line)]


def undocumented() -> list[str]:
    """Functions, types and constants of namespaces without a comment, which Doxygen does not report."""
    return [
        "{}:{}: {}".format(*location(entry), declaration(entry))
        for entry in everything()
        if entry.tag == "memberdef" and not is_boilerplate(entry) and not described(entry)
    ]


def pages() -> dict[str, str]:
    """The pages by their names."""
    if wrong := [*run_doxygen(), *undocumented()]:
        raise SystemExit(
            "\n".join([*wrong, "Every public symbol has a `///` line: what it is, units, shapes, errors."])
        )
    return {f"reference/cpp/{module}.md": page(module) for module in modules()}


def page(module: str) -> str:
    """One module: its headers in alphabetical order."""
    parts = [f"# `threewe/{module}`"]
    for header in headers():
        name = header.relative_to(INCLUDE / "threewe")
        if name.parts[0] == module:
            parts += [f"## {name}", introduction(header), f"```cpp\n#include <threewe/{name}>\n```", *symbols(header)]
    return "\n\n".join(part for part in parts if part) + "\n"


def introduction(header: Path) -> str:
    """The comment on top of a header, which says what it is; its indented lines are code."""
    lines = itertools.takewhile(lambda line: line.startswith("//"), header.read_text().splitlines())
    parts = []
    for is_code, group in itertools.groupby((line[3:] for line in lines), lambda line: line.startswith("  ")):
        text = list(group)
        parts.append("```cpp\n" + "\n".join(text) + "\n```" if is_code else paragraphs(text))
    return "\n\n".join(parts)


def paragraphs(lines: list[str]) -> str:
    """Lines of text, of which empty ones begin a paragraph."""
    return "\n\n".join(escaped(" ".join(text.split())) for text in "\n".join(lines).split("\n\n"))


def symbols(header: Path) -> Iterator[str]:
    """Everything public in a header, in its order: classes, functions, constants."""
    path = header.relative_to(ROOT).as_posix()
    found = [entry for entry in everything() if location(entry)[0] == path]
    for entry in sorted(found, key=lambda entry: location(entry)[1]):
        yield from class_parts(entry) if entry.tag == "compounddef" else member(entry)


@cache
def everything() -> list[ET.Element]:
    """All classes, and all members of namespaces, of all files."""
    found = []
    for file in sorted(XML.glob("*.xml")):
        for compound in ET.parse(file).getroot().iter("compounddef"):
            if compound.get("kind") in ("class", "struct") and compound.get("prot") == "public":
                found.append(compound)
            if compound.get("kind") == "namespace":
                found += [entry for entry in compound.iter("memberdef") if entry.get("kind") in SHOWN]
    return found


def location(entry: ET.Element) -> tuple[str, int]:
    """The file and line in which something is declared."""
    place = entry.find("location")
    file = (place.get("declfile") or place.get("file", "")).removeprefix(f"{ROOT}/")
    return file if file.startswith("include/") else f"include/{file}", int(place.get("line", 0))


def class_parts(compound: ET.Element) -> Iterator[str]:
    """A class: what it is, its fields as a table, then its functions."""
    name = (compound.findtext("compoundname") or "").removeprefix("threewe::")
    bases = ", ".join(plain(base) for base in compound.findall("basecompoundref") if base.get("prot") == "public")
    yield f"### {name}"
    yield described(compound)
    if bases:
        yield f"Derives from `{bases}`."
    public = [
        entry
        for section in compound.findall("sectiondef")
        for entry in section.findall("memberdef")
        if entry.get("prot") == "public" and entry.get("kind") in SHOWN and not is_boilerplate(entry)
    ]
    fields = [entry for entry in public if entry.get("kind") == "variable"]
    if fields:
        rows = [f"| `{cell(declaration(entry))}` | {cell(described(entry))} |" for entry in fields]
        yield "\n".join(["| field | |", "|---|---|", *rows])
    for entry in public:
        if entry.get("kind") != "variable":
            yield from member(entry)


def member(entry: ET.Element) -> Iterator[str]:
    """A function, constant, type or enumeration: how it is declared, and what it is."""
    if is_boilerplate(entry):
        return
    yield f"```cpp\n{declaration(entry)};\n```"
    yield described(entry)
    values = [value for value in entry.findall("enumvalue") if described(value)]
    if values:
        yield "\n".join(f"- `{value.findtext('name')}`: {described(value)}" for value in values)


def declaration(entry: ET.Element) -> str:
    """How something is declared, on one line."""
    kind, name = entry.get("kind"), entry.findtext("name") or ""
    of_type = plain(entry.find("type"))
    start = plain(entry.find("initializer"))
    if kind == "enum":
        values = ", ".join(value.findtext("name") or "" for value in entry.findall("enumvalue"))
        return f"enum {'class ' if entry.get('strong') == 'yes' else ''}{name} {{ {values} }}"
    if kind == "typedef":
        return f"using {name} = {of_type}"
    if kind == "variable":
        array = entry.findtext("argsstring") or ""
        return tidy(f"{of_type} {name}{array}{' ' + start if start.startswith('=') else start}")
    prefix = "explicit " if entry.get("explicit") == "yes" else ""
    prefix += "static " if entry.get("static") == "yes" and entry.get("id", "").startswith(("class", "struct")) else ""
    return tidy(f"{template(entry)}{prefix}{of_type} {name}{entry.findtext('argsstring') or ''}")


def template(entry: ET.Element) -> str:
    """`template <...> ` of a function that has parameters of such a kind."""
    parameters = entry.find("templateparamlist")
    if parameters is None:
        return ""
    names = [f"{plain(one.find('type'))} {one.findtext('declname') or ''}".strip() for one in parameters]
    return f"template <{', '.join(names)}> "


def is_boilerplate(entry: ET.Element) -> bool:
    """Comparison, copying and destruction, which do what everyone expects."""
    name, arguments = entry.findtext("name") or "", entry.findtext("argsstring") or ""
    return name.startswith(("~", "operator==", "operator!=")) or bool(re.search(r"=\s*(default|delete)$", arguments))


def described(entry: ET.Element) -> str:
    """What the comment of a symbol says, as Markdown."""
    parts = [prose(entry.find(tag)) for tag in ("briefdescription", "detaileddescription")]
    return "\n\n".join(part for part in parts if part)


def prose(node: ET.Element | None) -> str:
    """Paragraphs and lists of a comment."""
    if node is None:
        return ""
    blocks = []
    for child in node:
        if child.tag == "itemizedlist":
            blocks.append("\n".join(f"- {prose(item)}" for item in child))
        elif child.tag == "para":
            lists = [part for part in child if part.tag == "itemizedlist"]
            blocks.append(inline(child))
            blocks += ["\n".join(f"- {prose(item)}" for item in part) for part in lists]
        else:
            blocks.append(inline(child))
    return "\n\n".join(block for block in blocks if block.strip())


def inline(node: ET.Element) -> str:
    """One paragraph, with code in backquotes."""
    text = escaped(node.text or "")
    for child in node:
        if child.tag == "computeroutput":
            text += f"`{plain(child)}`"
        elif child.tag != "itemizedlist":
            text += inline(child)
        text += escaped(child.tail or "")
    return " ".join(text.split())


def plain(node: ET.Element | None) -> str:
    """The text of a node without its marks."""
    return tidy("".join(node.itertext())) if node is not None else ""


def tidy(code: str) -> str:
    """C++ as this project writes it, where Doxygen puts spaces elsewhere."""
    code = re.sub(r"\s+", " ", code).strip()
    code = re.sub(r" ([&*]+)(?=\w)", r"\1 ", code)
    code = re.sub(r" ([&*]+)(?=[,)>]|$)", r"\1", code)
    return re.sub(r"< (.*?) >", r"<\1>", code.replace("< ", "<").replace(" >", ">"))


def escaped(text: str) -> str:
    """Text in which nothing is taken for a mark of Markdown or HTML."""
    return re.sub(r"([*_\[\]<])", lambda match: "&lt;" if match[0] == "<" else f"\\{match[0]}", html.unescape(text))


def cell(text: str) -> str:
    """The same inside a table."""
    return text.replace("|", "\\|").replace("\n\n", "<br>").replace("\n", " ")
