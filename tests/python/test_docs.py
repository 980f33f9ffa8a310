"""The documentation is complete, in the field's words, and names only what there is.

That links lead somewhere, examples run and every public C++ symbol has a comment is for `./dev docs` to show.
"""

import ast
import importlib
import inspect
import json
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest
import threewe
from rules.test_vocabulary import FORBIDDEN

from verify.__main__ import AREAS, area

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "benchmarks/README.md")),
    *sorted(DOCS.rglob("*.md")),
]
DECISIONS = sorted((DOCS / "decisions").glob("0*.md"))
PUBLIC = [
    "threewe",
    "threewe.ai",
    "threewe.benchmark",
    "threewe.calibration",
    "threewe.data",
    "threewe.language",
    "threewe.slam",
    "threewe.teleop",
    "threewe.testing",
]
LEARNING = "threewe.gym"
NOT_USED = "## Words that are not used"

# Words of the glossary's last table that are plain English where no name has them.
ENGLISH = {
    "beginning": "of an episode, a row, a scan",
    "carry": "what casters do",
    "carried": "likewise",
    "lies": "where a point is",
    "looks": "what people do, and how something appears",
    "moment": "a short time",
    "moments": "likewise",
    "sound": "what ultrasonic sensors send; a sensor that is well",
    "words": "of an instruction, of this project",
}
TWO_WORDS = {r"creep(?! mode)": "creep mode", r"(?<!standard )deviations?": "standard deviation"}


def old_words() -> dict[str, str]:
    """What not to say, as patterns, and what to say instead: the glossary's last table."""
    table = (DOCS / "glossary.md").read_text().partition(NOT_USED)[2]
    rows = re.findall(r"^\| ([^|]+) \| ([^|]+) \|$", table, re.M)[1:]
    return {word: instead for words, instead in rows for word in words.split(", ")}


def blocks_left_out(text: str) -> str:
    """The prose of a page: without code and rows of ./dev verify, whose names are others', nor where links lead."""
    text = re.sub(r"^```.*?^```$", "", text, flags=re.M | re.S)
    text = text.partition(NOT_USED)[0]
    text = re.sub(r"`[^`]*`(,\s\"[^\"]*\")?|\]\([^)]*\)|<!--.*?-->|^:::.*$", "", text, flags=re.M)
    return " ".join(text.split())


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_pages_have_the_fields_words(page: Path) -> None:
    prose = blocks_left_out(page.read_text())
    wrong = [f"'{found}' ({instead}): {where!r}" for found, instead, where in wrong_words(prose)]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("name", AREAS)
def test_claims_have_the_fields_words(name: str) -> None:
    one = area(name)
    texts = [one.title, *(experiment.name for experiment in one.experiments)]
    for row in (row for experiment in one.experiments for row in experiment.rows):
        texts += [row.name, row.known_miss.why if row.known_miss else ""]
    wrong = [f"'{found}' ({instead}): {text}" for text in texts for found, instead, _ in wrong_words(text)]
    assert not wrong, "\n".join(wrong)


def wrong_words(prose: str) -> Iterator[tuple[str, str, str]]:
    """Each old word, what to say instead, and its surroundings."""
    plain = {word: instead for word, instead in old_words().items() if word not in ENGLISH}
    for old, instead in {**plain, **TWO_WORDS}.items():
        for match in re.finditer(rf"\b({old})\b", prose, re.I):
            yield match[0], instead, prose[max(0, match.start() - 40) : match.end() + 40]


def test_the_words_are_found() -> None:
    prose = blocks_left_out("A robot's mind reckons `mind` ([x](mind.md)); creep mode, standard deviation, Scatter.")
    assert {found for found, _, _ in wrong_words(prose)} == {"mind", "reckons", "Scatter"}


def test_the_table_has_what_no_name_may_have() -> None:
    assert set(FORBIDDEN) <= set(old_words())


def test_the_front_page_says_what_the_robot_without_a_lidar_did() -> None:
    runs = json.loads((ROOT / "verify/results/navigation.json").read_text())
    [run] = [run for name, run in runs.items() if "3we_base_v2 in office_v2" in name]
    figures = {row["row"]: row["figure"] for row in run["rows"]}
    arrived = figures["ends truly within 0.25 m"].partition("/")[0]
    bumped = run["cases"] - int(figures["without any contact"].partition("/")[0])
    fastest = re.search(r"worst ([\d.]+)", figures["contact by its own motion [m/s]"])
    assert fastest
    words = (
        f"of {run['cases']} sampled drives in `office_v2` {arrived} ended within 0.25 m of their goal, "
        f"and {bumped} bumped into something on the way, at {float(fastest[1]):.2f} m/s at most."
    )
    assert words in " ".join((ROOT / "README.md").read_text().split())


def test_every_public_name_is_on_a_page_of_the_reference() -> None:
    shown = {line.split()[1] for page in (DOCS / "reference").glob("*.md") for line in references(page)}
    public = {f"{module}.{name}" for module in PUBLIC for name in importlib.import_module(module).__all__}
    again = {"threewe.slam", "threewe.testing", "threewe.calibration", "threewe.benchmark"}
    missing = {
        name for name in public - shown if name != "threewe.__version__" and not is_shown_elsewhere(name, shown, again)
    }
    assert not missing


def references(page: Path) -> list[str]:
    return [line for line in page.read_text().splitlines() if line.startswith("::: ")]


def is_shown_elsewhere(name: str, shown: set[str], modules: set[str]) -> bool:
    """Whether the same object is on a page under another module's name."""
    module, _, last = name.rpartition(".")
    return module in modules and f"threewe.{last}" in shown


def members() -> Iterator[tuple[str, object]]:
    """Every public class, function, method and property, with its name."""
    for module in map(
        importlib.import_module, [*PUBLIC, "threewe.backend", "threewe.sync", LEARNING, "threewe.errors"]
    ):
        for name, value in public_members(module):
            yield name, value
            if inspect.isclass(value) and value.__module__.startswith("threewe"):
                for attribute, member in vars(value).items():
                    if not attribute.startswith("_") and is_documented_kind(member):
                        yield f"{name}.{attribute}", member


def public_members(module: ModuleType) -> Iterator[tuple[str, object]]:
    names = getattr(module, "__all__", None) or [name for name in vars(module) if not name.startswith("_")]
    for name in names:
        value = getattr(module, name)
        if getattr(value, "__module__", "").startswith("threewe") and (inspect.isclass(value) or callable(value)):
            yield f"{module.__name__}.{name}", value


def is_documented_kind(member: object) -> bool:
    return isinstance(member, (property, staticmethod, classmethod)) or callable(member)


def test_every_public_symbol_has_a_docstring() -> None:
    missing = sorted({name for name, value in members() if not inspect.getdoc(value)})
    assert not missing


def compiled() -> Iterator[tuple[str, ast.FunctionDef]]:
    """Every method, property and function of the compiled module that users get, as the stub has it."""
    public = {
        name.rpartition(".")[2] for name, value in members() if getattr(value, "__module__", "") == "threewe._core"
    }
    for entry in ast.parse((ROOT / "python/threewe/_core.pyi").read_text()).body:
        if isinstance(entry, (ast.ClassDef, ast.FunctionDef)) and entry.name in public:
            for function in entry.body if isinstance(entry, ast.ClassDef) else [entry]:
                if isinstance(function, ast.FunctionDef) and not function.name.startswith("_"):
                    yield f"{entry.name}.{function.name}", function


def test_arrays_say_their_shape_and_quantities_their_unit() -> None:
    found = [(name, function, ast.get_docstring(function) or "") for name, function in compiled()]
    assert len(found) > 200
    results = [(name, ast.unparse(function.returns), text) for name, function, text in found if function.returns]
    shapeless = [name for name, kind, text in results if "NDArray" in kind and not re.search(r"\(\w[^)]*,", text)]
    assert not shapeless
    unitless = [f"{name}: {text}" for name, kind, text in results if kind == "float" and not says_its_unit(text)]
    assert not unitless
    unclear = [name for name, function, text in found if takes_quantities(function) and not says_its_unit(text)]
    assert not unclear


def takes_quantities(function: ast.FunctionDef) -> bool:
    kinds = [ast.unparse(given.annotation) for given in function.args.args if given.annotation]
    return any(re.search(r"\bfloat\b|NDArray", kind) for kind in kinds)


def says_its_unit(text: str) -> bool:
    """[m] and the like; or a word that says that there is none."""
    return bool(
        re.search(r"\[[^\]]+\]|share|profile's unit|factor|times|ratio|0 to 1|percent|weight|score|pixels", text)
    )


def test_diagrams_are_as_the_program_draws_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(DOCS / "site")
    diagrams = importlib.import_module("diagrams")
    monkeypatch.setattr(diagrams, "MEDIA", tmp_path)
    diagrams.draw_all()
    drawn = sorted(tmp_path.glob("*.svg"))
    assert len(drawn) == 5
    for path in drawn:
        assert path.read_text() == (DOCS / "media" / path.name).read_text(), "run python docs/site/diagrams.py"


@pytest.mark.parametrize("page", DECISIONS, ids=lambda page: page.stem)
def test_a_decision_has_its_four_parts(page: Path) -> None:
    text = page.read_text()
    parts = ["Context", "Decision", "Measurement", "What was tried"]
    assert re.findall(r"^## (.+)$", text, re.M) == parts
    assert text.startswith(f"# {int(page.name[:4])}. ")
    measurement = text[text.index("## Measurement") : text.index("## What was tried")]
    assert re.search(r"`(\./dev|pytest|build/dev/tests)[^`]*`", measurement), "no command repeats it"


def test_decisions_are_numbered_and_listed() -> None:
    assert [int(page.name[:4]) for page in DECISIONS] == list(range(1, len(DECISIONS) + 1))
    index = (DOCS / "decisions/README.md").read_text()
    assert re.findall(r"\]\((0\d{3}-[^)]+)\)", index) == [page.name for page in DECISIONS]


def test_every_file_that_is_named_exists() -> None:
    folders = [ROOT / folder for folder in (".", "include", "src")]
    for page in PAGES:
        for name in re.findall(r"`([\w.-]+/[\w./-]+\.(?:py|hpp|cpp|yaml))`", page.read_text()):
            assert any((folder / name).exists() for folder in folders), f"{page}: {name}"


def test_every_cpp_name_exists() -> None:
    sources = " ".join(path.read_text() for top in ("include", "src") for path in (ROOT / top).rglob("*.[ch]pp"))
    known = set(re.findall(r"\w+", sources))
    for page in PAGES:
        text = re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.M | re.S)
        for name in re.findall(r"`(?:\w+::)+(\w+)", text):
            assert name in known, f"{page}: {name}"


def test_every_measurement_that_is_named_exists() -> None:
    benchmarks = {path.stem.removesuffix("_bench") for path in (ROOT / "benchmarks").glob("*_bench.*")}
    for page in PAGES:
        text = " ".join(page.read_text().split())
        for name, experiment in re.findall(r'\./dev verify ([a-z0-9]+)(?: --only "([^"]+)")?', text):
            source = ROOT / "verify" / f"{name}.py"
            assert source.exists() or name == "claims", f"{page}: {name}"
            assert not experiment or experiment in source.read_text(), f"{page}: no {experiment!r} in {name}"
        for name in re.findall(r"\./dev bench ([a-z]+)", text):
            assert name in benchmarks, f"{page}: {name}"


def test_the_page_of_parameters_names_each() -> None:
    rows = re.findall(r"^\| `([\w.]+)` \| (\S+)", (ROOT / "docs/parameters.md").read_text(), re.MULTILINE)
    parameters = threewe.RobotProfile.load("3we_standard_v2").parameters()
    assert dict(rows) == {parameter.name: f"{parameter.value:.4g}" for parameter in parameters}


def test_every_term_of_the_glossary_is_defined_once() -> None:
    rows = re.findall(r"^\| ([^|`]+) \| [^|]+ \|$", (DOCS / "glossary.md").read_text().partition(NOT_USED)[0], re.M)
    terms = [term.strip() for row in rows for term in row.split(",") if row != "term"]
    assert sorted(terms) == sorted(set(terms))
