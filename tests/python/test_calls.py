"""Calls with arguments of wrong types, all over the public API: each is one error that names the argument."""

from __future__ import annotations

import asyncio
import inspect
import re
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
import threewe
import threewe.sync
from threewe import ContractError, LaserScan, Pose2D, Robot, Scene, Zone
from threewe._calls import Signature, read_signature


class Wrong:
    """What no function takes."""


SAMPLES: dict[str, Any] = {
    "float": 1.0,
    "int": 1,
    "bool": True,
    "str": "office_v2",
    "tuple[float, float]": (1.0, 2.0),
    "threewe._core.Pose2D": Pose2D(1.0, 2.0, 0.5),
    "threewe._core.Scene": Scene.load("corridor_v1"),
    "threewe._core.RobotProfile": threewe.RobotProfile.load("3we_standard_v2"),
    "threewe._core.Kinematics": threewe.Kinematics.holonomic,
    "threewe._core.SensorType": threewe.SensorType.lidar,
    "threewe._core.Velocity": threewe.Velocity(),
    "threewe._core.OccupancyGrid": threewe.OccupancyGrid(np.zeros((4, 4), np.int8)),
}


def sample(kind: str) -> Any:
    """A value of a parameter's type."""
    if kind in SAMPLES:
        return SAMPLES[kind]
    if "ndarray" in kind:
        shape = re.search(r"shape=\(([^)]*)\)", kind)
        assert shape
        return np.zeros([4] * len(shape[1].split(",")), re.search(r"dtype=(\w+)", kind)[1])  # type: ignore[index]
    if kind.startswith("collections.abc.Sequence") and kind.endswith("[float]"):
        return [0.0, 0.0, 0.0]
    return [] if "Sequence" in kind else None


def overloads(function: Any) -> list[Signature]:
    """The signatures that nanobind has of a function, without `self`."""
    texts = [signature[0].removeprefix("def ") for signature in function.__nb_signature__]
    return [read_signature(re.sub(r"\\\d+", "...", text), function.__name__) for text in texts]


def bound_functions() -> Iterator[tuple[str, Any, bool]]:
    """All that the core brings into the public API: its name, the function, and whether it takes an object first."""
    for name in threewe.__all__:
        entity = getattr(threewe, name)
        if hasattr(entity, "__nb_signature__"):
            yield name, entity, False
        if isinstance(entity, type) and entity.__module__ == "threewe._core":
            for member, function in vars(entity).items():
                if not hasattr(function, "__nb_signature__") or (member.startswith("__") and member != "__init__"):
                    continue
                yield f"{name}.{member}", function, "(self" in function.__nb_signature__[0][0]


FUNCTIONS = {name: (function, is_method) for name, function, is_method in bound_functions()}


def wrong_calls(name: str) -> Iterator[tuple[str, Callable[[], object]]]:
    function, is_method = FUNCTIONS[name]
    owner = getattr(threewe, name.partition(".")[0])
    for signature in overloads(function):
        for wrong in signature.parameters:
            if wrong.type == "object":
                continue
            arguments = {p.name: sample(p.type) for p in signature.parameters if p.required}
            arguments[wrong.name] = Wrong()
            if name.endswith("__init__"):
                yield wrong.name, lambda arguments=arguments: owner(**arguments)  # type: ignore[misc]
            elif is_method:
                itself = SAMPLES.get(f"threewe._core.{owner.__name__}")
                if itself is None or wrong.by_place_only:
                    continue
                yield wrong.name, lambda arguments=arguments, of=itself: function(of, **arguments)  # type: ignore[misc]
            else:
                yield wrong.name, lambda arguments=arguments: function(**arguments)  # type: ignore[misc]


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_the_core_names_the_argument(name: str) -> None:
    for argument, call in wrong_calls(name):
        with pytest.raises(ContractError, match=rf"\b{argument}\b must be .*, got Wrong$"):
            call()


def test_the_walk_is_not_empty() -> None:
    assert sum(len(list(wrong_calls(name))) for name in FUNCTIONS) > 60
    assert {"Pose2D.__init__", "LaserScan.__init__", "Scene.load", "Zone.__init__", "force_target"} <= set(FUNCTIONS)


@pytest.mark.parametrize(
    ("call", "error", "text"),
    [
        (lambda: Pose2D("1"), ContractError, "Pose2D(): x must be a number, got a string"),
        (lambda: Pose2D(1, 2, 3, 4), TypeError, "Pose2D() takes x, y, theta by place, got 4 arguments"),
        (lambda: Pose2D(z=1), TypeError, "Pose2D() has no argument 'z'; it takes x, y, theta"),
        (lambda: threewe.BatteryState(7.4, 0.5), TypeError, "BatteryState() needs charge"),
        (lambda: Zone("abc"), ContractError, "Zone(): corners must be a list of (float, float), got a string"),
        (
            lambda: Zone([(0, 0), (1,)]),
            ContractError,
            "Zone(): corners must be a list of (float, float), and something in the list given is none",
        ),
        (
            lambda: Scene.generate(-1),
            ContractError,
            "generate(): seed must be a whole number, and the one given is negative or too large",
        ),
        (
            lambda: threewe.OccupancyGrid([[0]]),
            ContractError,
            "OccupancyGrid(): data must be an int8 array of shape (*, *), and something in the list given is none",
        ),
        (lambda: threewe.SceneTables(1, 2), ContractError, "SceneTables(): scene must be Scene, got a whole number"),
    ],
)
def test_what_is_said(call: Callable[[], object], error: type[Exception], text: str) -> None:
    with pytest.raises(error) as caught:
        call()
    assert str(caught.value) == text


def test_text_that_is_no_utf8() -> None:
    half = "go \udcff"
    with threewe.sync.Robot(scene="corridor_v1", hardware="3we_standard_v2") as robot:
        calls: dict[str, Callable[[], object]] = {
            "load(): name": lambda: Scene.load(half),
            "parse(): text or name": lambda: Scene.parse("name: x", half),
            "name_place(): name": lambda: robot.name_place(half, [(0, 0), (1, 0), (1, 1)]),
            "begin(): instruction": lambda: robot.execute_instruction(half),
        }
        for argument, call in calls.items():
            with pytest.raises(ContractError) as caught:
                call()
            assert str(caught.value) == f"{argument} must be text that UTF-8 can hold, got 'go \\udcff'"


def test_operators_leave_it_to_python() -> None:
    with pytest.raises(TypeError, match="unsupported operand"):
        Pose2D() * 3  # type: ignore[operator]
    assert Pose2D() != "x"


# The part that is written in Python

PYTHON = {
    "Robot": lambda **options: Robot(**options),
    "World": lambda **options: threewe.World(**options),
    "sync.World": lambda **options: threewe.sync.World(**options),
    "export": lambda **options: threewe.export(**{"scene": "corridor_v1", "robot": "3we_standard_v2"} | options),
    "register_backend": threewe.register_backend,
    "calibrate": threewe.calibrate,
}
REQUIRED: dict[str, dict[str, object]] = {
    "export": {"format": "map", "folder": "out"},
    "register_backend": {"name": "some", "factory": print},
    "calibrate": {"backend": "mock"},
    "move_to": {"x": 1.0, "y": 0.0},
    "move_forward": {"distance": 0.1},
    "rotate": {"angle": 0.1},
    "follow_path": {"path": [(0.5, 0.0)]},
    "follow_waypoints": {"waypoints": [(0.5, 0.0)]},
    "execute_action": {"action": (0.0, 0.0, 0.0)},
    "execute_instruction": {"instruction": "look around"},
    "execute_skill": {"skill": "look"},
    "add_skill": {"function": print},
    "name_place": {"name": "dock"},
    "load_places": {"path": "places.yaml"},
    "save_places": {"path": "places.yaml"},
    "get_transform": {"target": "map", "source": "base"},
    "sleep": {"seconds": 0.02},
    "timeout": {"seconds": 1.0},
    "geodesic": {"a": (0.0, 0.0), "b": (1.0, 0.0)},
}


def parameters_of(function: Callable[..., object]) -> list[str]:
    signature = inspect.signature(function).parameters.values()
    return [p.name for p in signature if p.name != "self" and p.kind not in (p.VAR_POSITIONAL, p.VAR_KEYWORD)]


@pytest.mark.parametrize("name", PYTHON)
def test_functions_name_the_argument(name: str) -> None:
    of = {"Robot": Robot, "World": threewe.World, "sync.World": threewe.World, "export": threewe.export}
    for parameter in parameters_of(of.get(name, PYTHON[name])):
        with pytest.raises((ContractError, TypeError), match=rf"\b{parameter}\b"):
            PYTHON[name](**{**REQUIRED.get(name, {}), parameter: Wrong()})


async def wrong_arguments(owner: object) -> list[str]:
    """Calls that were not refused, or without naming the argument."""
    bad: list[str] = []
    for name, method in inspect.getmembers(type(owner), inspect.isfunction):
        if name.startswith("_"):
            continue
        for parameter in parameters_of(method):
            call = getattr(owner, name)
            try:
                done = call(**{**REQUIRED.get(name, {}), parameter: Wrong()})
                if inspect.iscoroutine(done):
                    await asyncio.wait_for(done, 10.0)
                bad.append(f"{name}({parameter}) took it")
            except Exception as error:
                named = re.search(rf"\b{parameter}\b", str(error)) and isinstance(error, ContractError | TypeError)
                if not named or "incompatible" in str(error):
                    bad.append(f"{name}({parameter}): {type(error).__name__}: {error}")
    return bad


async def test_methods_name_the_argument() -> None:
    async with Robot(scene="corridor_v1", noise="ideal") as robot:
        assert await wrong_arguments(robot) == []
        assert robot.simulation is not None
        assert await wrong_arguments(robot.simulation) == []


def test_scans_take_lists_that_become_arrays() -> None:
    scan = LaserScan(np.ones(3, np.float32), 0.0, 0.1, 0.1, 5.0)
    assert len(scan) == 3
