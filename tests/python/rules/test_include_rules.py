"""What may include what: the table below is the whole of it."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]

# Every module may use itself, and of the others only these. "scene/truth_view" is that one header.
MAY_USE = {
    "core": [],
    "language": ["core"],
    "hardware": ["core"],
    "scene": ["core"],
    "models": ["core", "hardware"],
    "vision": ["core"],
    "policy": ["core", "hardware"],
    "map": ["core"],
    "slam": ["core", "map"],
    "perception": ["core", "hardware", "map", "slam", "safety/params"],
    "semantics": ["core", "map", "vision"],
    "nav": ["core", "hardware", "map", "slam", "perception/percepts", "safety/params"],
    "sim": ["core", "scene", "hardware", "models"],
    "backend": ["core", "hardware", "scene/truth_view"],
    "backend/simulated": ["backend", "core", "hardware", "scene", "models", "sim"],
    "backend/mock": ["backend", "backend/simulated", "core", "sim"],
    "backend/mujoco": ["backend", "backend/simulated", "core", "hardware", "scene", "models", "sim", "export"],
    "backend/known": ["backend", "backend/mock", "backend/mujoco", "ros2", "gazebo", "core"],
    "gazebo": ["core", "hardware", "backend", "backend/simulated", "scene"],
    "ros2": ["core", "hardware", "backend", "scene/truth_view", "map", "export"],
    "safety": ["core", "hardware", "map/scan_hits"],
    "robot": ["core", "backend", "safety", "perception", "slam", "nav", "map", "hardware", "scene/truth_view"],
    "agent": ["core", "hardware", "map", "slam", "nav", "language", "vision", "semantics", "robot"],
    "agent/robot": ["core", "agent", "robot", "semantics"],
    "export": ["core", "scene", "hardware", "map"],
    "task": ["core", "hardware", "scene", "language"],
    "env": ["core", "hardware", "scene", "task", "sim", "models", "safety"],
    "env/robot": ["core", "hardware", "scene", "task", "sim", "env", "backend", "slam", "robot"],
    "calibration": ["core", "hardware", "scene", "models", "sim", "backend"],
    "benchmark": ["core", "hardware", "scene", "backend", "robot", "task", "env"],
    "record": ["core", "hardware", "backend", "robot", "scene/truth_view"],
}

# What users call, and what is installed.
PUBLIC = ROOT / "include/threewe"
MOST_PUBLIC_HEADERS = 45

# The robot's mind never sees, through however many includes, what only a simulator knows.
MIND = ["map", "slam", "perception", "nav", "language", "vision", "semantics", "policy"]
HIDDEN_FROM_THE_MIND = ["scene", "sim", "backend", "ros2", "gazebo"]


def test_every_include_is_allowed() -> None:
    wrong = [
        f"{file.relative_to(ROOT)}:{line}: {module_of(file)} may not include {target.relative_to(ROOT)}"
        for file in sources()
        for line, target in includes(file)
        if not allowed(module_of(file), target)
    ]
    assert not wrong, "\n".join(wrong)


def test_the_mind_sees_no_truth() -> None:
    seen = {file: reachable(file) for file in sources() if module_of(file) in MIND}
    wrong = [
        f"{file.relative_to(ROOT)} sees {target.relative_to(ROOT)}"
        for file, targets in seen.items()
        for target in targets
        if module_of(target).split("/")[0] in HIDDEN_FROM_THE_MIND
    ]
    assert not wrong, "\n".join(wrong)


def test_the_agent_of_instructions_sees_no_truth() -> None:
    files = [file for file in sources() if module_of(file) == "agent"]
    assert files
    assert not [target for file in files for target in reachable(file) if module_of(target) in ("scene", "sim")]


def test_factories_and_observers_are_given_no_truth() -> None:
    given = ["backend/world", "robot/runtime", "robot/world", "slam/localizer", "nav/navigator"]
    wrong = [
        f"{name}.hpp sees {target.relative_to(ROOT)}"
        for name in given
        for target in reachable(PUBLIC / f"{name}.hpp")
        if module_of(target) == "scene"
    ]
    assert not wrong, "\n".join(wrong)
    assert any(module_of(target) == "scene" for target in reachable(PUBLIC / "robot/simulation.hpp"))


def test_installed_headers_include_installed_ones_alone() -> None:
    wrong = [
        f"{file.relative_to(ROOT)}:{line}: {text}"
        for file in PUBLIC.rglob("*.hpp")
        for line, text in enumerate(file.read_text().splitlines(), 1)
        if (match := re.match(r'#include "([^"]+)"', text)) and not (ROOT / "include" / match[1]).is_file()
    ]
    assert not wrong, "\n".join(wrong)


def test_few_headers_are_installed() -> None:
    assert len(list(PUBLIC.rglob("*.hpp"))) <= MOST_PUBLIC_HEADERS, "what no user calls belongs into src/<module>"


def test_every_folder_is_a_known_module() -> None:
    unknown = {module_of(file) for file in sources()} - set(MAY_USE)
    assert not unknown


@pytest.mark.parametrize(
    ("module", "header", "expected"),
    [
        ("nav", "map/occupancy_grid.hpp", True),
        ("nav", "scene/scene.hpp", False),
        ("backend", "scene/truth_view.hpp", True),
        ("backend", "scene/scene.hpp", False),
        ("backend", "backend/mock/mock.hpp", False),
        ("backend/mock", "sim/batch.hpp", True),
        ("core", "hardware/profile.hpp", False),
    ],
)
def test_the_rules_can_tell(module: str, header: str, expected: bool) -> None:
    assert allowed(module, ROOT / "include/threewe" / header) == expected


def allowed(module: str, target: Path) -> bool:
    """Whether a file of the module may include the target."""
    rules = MAY_USE.get(module, [])
    return module_of(target) in [module, *rules] or f"{module_of(target)}/{target.stem}" in rules


def sources() -> list[Path]:
    """All headers and sources of the modules."""
    found = [path for folder in ("include/threewe", "src") for path in (ROOT / folder).glob("*/**/*.[ch]pp")]
    assert found
    return sorted(found)


def module_of(file: Path) -> str:
    """The module whose file this is: its folder under include/threewe or src, or the nearest one around it."""
    folder = file.parent
    base = next(ROOT / top for top in ("include/threewe", "src") if folder.is_relative_to(ROOT / top))
    name = folder.relative_to(base).as_posix()
    while name not in MAY_USE and "/" in name:
        name = name.rpartition("/")[0]
    return name


def includes(file: Path) -> Iterator[tuple[int, Path]]:
    """The files of ours that a file includes, with the line."""
    for line, text in enumerate(file.read_text().splitlines(), 1):
        if match := re.match(r'\s*#\s*include\s*[<"]([^">]+)[">]', text):
            name = match[1]
            candidates = [ROOT / "include" / name, ROOT / "src" / name, file.parent / name]
            target = next((path.resolve() for path in candidates if path.is_file()), None)
            if target:
                yield line, target
            else:
                assert not name.startswith("threewe/"), f"{file}:{line}: there is no {name}"


def reachable(file: Path) -> set[Path]:
    """All files of ours that come in with a file."""
    seen: set[Path] = set()
    waiting = [file]
    while waiting:
        for _, target in includes(waiting.pop()):
            if target not in seen:
                seen.add(target)
                waiting.append(target)
    return seen
