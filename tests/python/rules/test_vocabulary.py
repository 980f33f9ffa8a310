"""The field's words: no private riddle is the name of anything that users read or write."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
import typer

ROOT = Path(__file__).resolve().parents[3]
PUBLIC = ROOT / "include/threewe"

# What not to say, as words of which a name is made, and what the field says.
FORBIDDEN = {
    "mind": "autonomy",
    "minds": "autonomy",
    "scatter": "noise, standard deviation",
    "trouble": "fault",
    "sound": "ok",
    "carry": "teleport",
    "carried": "kidnapped, teleported",
    "creeping": "creep mode",
    "squeeze": "narrow passage",
    "aside": "lateral offset",
    "beside": "lateral offset, next to",
    "neck": "narrow passage",
    "gap": "narrow passage, doorway",
    "optimist": "optimistic replanning",
    "hear": "update, receive",
    "hears": "receives",
    "heard": "received",
    "feel": "bump detection, measure",
    "feels": "measures",
    "echo": "sonar return",
    "echoes": "sonar returns",
    "crowd": "multi-body contact",
    "shot": "capture",
    "moment": "task state, capture",
    "sketch": "debug overlay",
    "words": "instruction",
    "manoeuvre": "excitation sequence, arc escape",
    "manoeuvres": "excitation sequences",
    "manoeuvring": "arc escape",
    "hall": "test arena",
    "pace": "velocity profile, real-time pacer, throughput",
    "looks": "materials",
    "paint": "shade",
    "meet": "intersect",
    "pull": "traction",
    "pulls": "traction",
    "grip": "friction",
    "stranger": "third party, independent parser",
    "strangers": "third parties",
    "wander": "soak test",
    "journey": "end-to-end hash",
    "lies": "false truth",
    "deaf": "without sonar",
    "beginning": "initial state, prior",
    "honest": "consistent",
    "survey": "recorded log, trajectory",
    "surveys": "recorded logs",
    "trail": "keyframe graph",
    "told": "commanded, informational, identifiable",
    "reckons": "computes",
    "somebody": "a person, a caller",
    "nobody": "none",
}
# Whole names that have gone, of words that are good in others.
GONE = {
    "GrowingMap": "OnlineMap",
    "growing_map": "online_map",
    "KnownMap": "PriorMap",
    "known_map": "prior_map",
    "MapError": "MapUncertainty",
    "map_error": "map_uncertainty",
    "Moment": "TaskState",
    "Passage": "NarrowPassage",
    "PlaceFinder": "GlobalLocalizer",
    "place_finder": "global_localizer",
    "ScanSearch": "BranchAndBoundMatcher",
    "scan_search": "branch_and_bound_matcher",
    "Setting": "TaskContext",
    "Tracker": "PathFollower",
    "is_back": "is_relocalized",
}

# Where a word is English and no name of ours: key or text, and why it may stay.
ALLOWED_KEYS = {("assets/languages/english_v1.yaml", "words"): "the vocabulary of instructions is a list of words"}
ALLOWED_TEXTS = {
    "beside": "a preposition that instructions use",
    "words": "the key of that vocabulary",
}


# Where a word is the field's for something else: a dataset is pulled from the Hub.
ALLOWED_IN = {"pull": ("python/threewe/data/", "threewe data "), "pulls": ("python/threewe/data/", "threewe data ")}


def wrong_words(name: str, where: str = "") -> list[str]:
    """What is wrong with a name or a text, and what to say instead."""
    parts = re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", name)
    found = [part for part in parts if part.lower() in FORBIDDEN]
    found = [part for part in found if not where.startswith(ALLOWED_IN.get(part.lower(), ("-",)))]
    wrong = [f"'{part}' (say {FORBIDDEN[part.lower()]})" for part in found]
    whole = [f"'{word}' (say {GONE[word]})" for word in re.findall(r"\w+", name) if word in GONE]
    return wrong + whole


def test_no_installed_header_has_them_in_a_name() -> None:
    wrong = {
        f"{file.relative_to(ROOT)}: {name}: {', '.join(why)}"
        for file in sorted(PUBLIC.rglob("*.hpp"))
        for name in re.findall(r"[A-Za-z_]\w*", cpp_code(file.read_text()))
        if (why := wrong_words(name))
    }
    assert not wrong, "\n".join(sorted(wrong))


def test_no_header_begins_with_them() -> None:
    headers = [file for top in ("include", "src") for file in sorted((ROOT / top).rglob("*.hpp"))]
    first = {file: file.read_text().partition("\n")[0] for file in headers}
    wrong = [
        f"{file.relative_to(ROOT)}: {', '.join(why)}" for file, line in first.items() if (why := wrong_words(line))
    ]
    assert not wrong, "\n".join(wrong)


def test_a_header_begins_with_a_noun() -> None:
    riddles = re.compile(r"// (What|How|Where|Who|When|Whether|Does|Do|Are|Is|From|Through|Puts|Keeps|The last word)\b")
    wrong = [str(file.relative_to(ROOT)) for file in sorted(PUBLIC.rglob("*.hpp")) if riddles.match(file.read_text())]
    assert not wrong, "the first line says what the header is, in the field's nouns: " + ", ".join(wrong)


def test_sentences_have_a_subject() -> None:
    riddles = re.compile(r"\b(somebody|nobody|anybody|everybody|whoever|reckon(s|ed)?|told(?! apart))\b", re.I)
    wrong = [
        f"{file.relative_to(ROOT)}:{number}: '{found[0]}' (say who or what: a caller, a person, the gate)"
        for top in ("include", "src", "python")
        for file in sorted((ROOT / top).rglob("*.*"))
        if file.suffix in (".hpp", ".cpp", ".py", ".pyi")
        for number, line in enumerate(file.read_text().splitlines(), 1)
        if (found := riddles.search(line))
    ]
    assert not wrong, "\n".join(wrong)


def test_no_file_is_named_by_them() -> None:
    folders = (
        "include",
        "src",
        "python/threewe",
        "python/bindings",
        "tests",
        "verify",
        "benchmarks",
        "examples",
        "assets",
    )
    files = [file for folder in folders for file in (ROOT / folder).rglob("*") if "__pycache__" not in file.parts]
    wrong = [f"{file.relative_to(ROOT)}: {', '.join(why)}" for file in files if (why := wrong_words(file.stem))]
    assert not wrong, "\n".join(sorted(wrong))


def test_no_public_name_of_the_python_package_has_them() -> None:
    package = ROOT / "python/threewe"
    wrong = [
        f"{file.relative_to(ROOT)}: {name}: {', '.join(why)}"
        for file in sorted([*package.rglob("*.py"), *package.rglob("*.pyi")])
        if file.name == "_core.pyi" or not file.name.startswith("_") or file.name == "__init__.py"
        for name in public_names(ast.parse(file.read_text()))
        if (why := wrong_words(name, str(file.relative_to(ROOT))))
    ]
    assert not wrong, "\n".join(wrong)


def test_no_command_no_option_and_no_help_has_them() -> None:
    from threewe.cli import app

    wrong = [
        f"{where}: {', '.join(why)}"
        for where, text in commands(typer.main.get_command(app))
        if (why := wrong_words(text, where))
    ]
    assert not wrong, "\n".join(wrong)


def test_no_key_of_our_files_has_them() -> None:
    keys = {
        (str(file.relative_to(ROOT)), key)
        for file in sorted((ROOT / "assets").rglob("*.yaml"))
        for key in re.findall(r"(?:^|[{,]|- )\s*([a-z_]+):(?=\s)", yaml_code(file.read_text()), re.M)
    }
    wrong = [
        f"{file}: {key}: {', '.join(why)}"
        for file, key in sorted(keys)
        if (why := wrong_words(key)) and (file, key) not in ALLOWED_KEYS
    ]
    assert not wrong, "\n".join(wrong)


def test_no_error_has_them() -> None:
    wrong = [
        f"{file.relative_to(ROOT)}: {text!r}: {', '.join(why)}"
        for file, text in texts()
        if (why := wrong_words(text, str(file.relative_to(ROOT)))) and text not in ALLOWED_TEXTS
    ]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("mind_with", True),
        ("RangeScatter", True),
        ("EchoMap", True),
        ("creeping_", True),
        ("Tracker", True),
        ("PeopleTracker", False),
        ("NarrowPassage", False),
        ("reminder", False),
        ("remind", False),
        ("SonarGrid", False),
    ],
)
def test_the_rule_can_tell(text: str, found: bool) -> None:
    assert bool(wrong_words(text)) == found


def test_the_rule_knows_where_a_word_is_right() -> None:
    assert wrong_words("pull", "python/threewe/nav.py")
    assert not wrong_words("pull", "python/threewe/data/hub.py")
    assert wrong_words("pull mind", "threewe data pull")[0].startswith("'mind'")


def cpp_code(text: str) -> str:
    """C++ without comments and strings."""
    return re.sub(r'//[^\n]*|"(?:\\.|[^"\\\n])*"', "", text)


def yaml_code(text: str) -> str:
    """YAML without comments."""
    return re.sub(r"#[^\n]*", "", text)


def texts() -> Iterator[tuple[Path, str]]:
    """All that the library may say: strings of its C++ sources, and of what Python raises."""
    for file in sorted((ROOT / "src").rglob("*.cpp")):
        code = re.sub(r"//[^\n]*|#include [^\n]*|#define [^\n]*", "", file.read_text())
        yield from ((file, text) for text in re.findall(r'"((?:\\.|[^"\\\n])*)"', code))
    for file in sorted((ROOT / "python/threewe").rglob("*.py")):
        for statement in ast.walk(ast.parse(file.read_text())):
            if isinstance(statement, ast.Raise):
                constants = (node.value for node in ast.walk(statement) if isinstance(node, ast.Constant))
                yield from ((file, text) for text in constants if isinstance(text, str))


def public_names(tree: ast.AST) -> Iterator[str]:
    """Names of classes, functions, their arguments and of attributes, without those that begin with an underscore."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            if node.name.startswith("_") and node.name != "__init__":
                continue
            yield node.name
            if isinstance(node, ast.ClassDef):
                yield from public_names(node)
            else:
                yield from (argument.arg for argument in ast.walk(node.args) if isinstance(argument, ast.arg))
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            yield from (name.id for name in targets if isinstance(name, ast.Name) and not name.id.startswith("_"))


def commands(command: object, path: str = "threewe") -> Iterator[tuple[str, str]]:
    """The name and help of a command, of its options and of all commands below it."""
    yield path, f"{path} {getattr(command, 'help', None) or ''}"
    for option in getattr(command, "params", []):
        yield f"{path} {option.name}", " ".join([option.name, *option.opts, getattr(option, "help", None) or ""])
    for name, below in getattr(command, "commands", {}).items():
        yield from commands(below, f"{path} {name}")
