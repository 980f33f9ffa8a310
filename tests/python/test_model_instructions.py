"""Instructions by a model behind an OpenAI-compatible address: what it may do, and what becomes of bad answers."""

import asyncio
import json
import math
import sys
import time
import urllib.request
from pathlib import Path
from typing import Any

import pytest
from threewe import ExecutionResult, Robot, Zone, sync
from threewe.errors import ConfigError, ContractError, HardwareError, SafetyError
from threewe.testing import ModelServer

pytest.importorskip("openai")
pytest.importorskip("PIL")

PLAN = [
    {"skill": "rotate", "degrees": 90},
    {"skill": "move_forward", "distance": 0.5},
    {"skill": "look"},
    {"skill": "done"},
]
DIALECTS = ["openai", "llama.cpp", "vllm", "ollama", "lmstudio", "llama-cpp-python", "transformers"]


@pytest.fixture(autouse=True)
def _no_keys(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("OPENAI_API_KEY", "THREEWE_MODEL_KEY", "THREEWE_MODEL"):
        monkeypatch.delenv(name, raising=False)


def execute(answers: Any, text: str = "look for a chair", *, server: Any = None, **options: Any) -> ExecutionResult:
    """Of a robot at the start of its scene; thinking takes no robot time."""
    with ModelServer(answers, **(server or {})) as model, sync.Robot() as robot:
        return robot.execute_instruction(text, model=model.url, **{"thinking_time": 0.0, **options})


@pytest.mark.parametrize("dialect", DIALECTS)
def test_a_planner_as_good_as_ours_drives_as_ours(dialect: str) -> None:
    def drive(**model: Any) -> tuple[object, ...]:
        with sync.Robot(seed=5) as robot:
            text = "turn left 90 degrees, move forward 50 cm, then look around"
            result = robot.execute_instruction(text, **model)
            assert result.success, result
            steps = [(step.text, step.reason, step.begun, step.ended) for step in result.steps]
            way = [tuple(pose) for pose in result.way]
            return steps, way[:-1] if model else way, robot.get_things()  # a model needs another 0.1 s to say `done`

    with ModelServer(PLAN, dialect=dialect) as server:
        assert drive(model=server.url, thinking_time=0.0) == drive()


def test_what_is_found_is_verified_by_the_robot_itself() -> None:
    plan = [
        {"skill": "search", "kind": "plant"},
        {"skill": "done", "found": {"kind": "plant"}, "answer": "There it is."},
    ]
    with ModelServer(plan) as server, sync.Robot(scene="office_v2", seed=3) as robot:
        result = robot.execute_instruction("find the plant", model=server.url, thinking_time=0.5)
        assert result.success, result
        assert result.verified
        assert result.answer == "There it is."
        assert result.thinking == 1.5  # the eyesight test and two answers
        assert result.tokens == 330
        pictures = [part for part in server.requests[-1]["messages"][0]["content"] if part["type"] == "image_url"]
        assert len(pictures) == 2
        assert all(part["image_url"]["url"].startswith("data:image/jpeg;base64,") for part in pictures)
        assert "plant" in server.requests[-1]["messages"][0]["content"][0]["text"]


ROOM = """
name: plants
description: a room with two plants
starts: [[4, 3, 0]]
rooms: [{name: lobby, min: [0, 0], max: [8, 6], floor: wood, anchor: [4, 3]}]
walls:
  - {a: [0, 0], b: [8, 0], thickness: 0.15}
  - {a: [8, 0], b: [8, 6], thickness: 0.15}
  - {a: [8, 6], b: [0, 6], thickness: 0.15}
  - {a: [0, 6], b: [0, 0], thickness: 0.15}
objects:
  - {category: plant, shape: ficus, pose: [6.2, 3, 0]}
  - {category: plant, shape: ficus, pose: [1.8, 3, 0]}
"""


@pytest.mark.parametrize(("turn", "verified"), [(1, False), (180, True), (90, False)])
def test_a_claim_counts_for_the_thing_that_it_names_alone(tmp_path: Path, turn: float, verified: bool) -> None:
    room = tmp_path / "plants.yaml"
    room.write_text(ROOM, encoding="utf-8")
    plan = [{"skill": "rotate", "degrees": turn}, {"skill": "done", "found": {"kind": "plant", "place": "corner"}}]
    with ModelServer(plan) as server, sync.Robot(scene=room) as robot:
        assert robot.execute_instruction("look around, then move forward 30 cm, then look around").success
        robot.name_place("corner", [(-3.5, -1), (-1, -1), (-1, 1), (-3.5, 1)])  # behind it; the other plant is ahead
        assert len(robot.get_things()) == 2
        result = robot.execute_instruction("find the plant", model=server.url, thinking_time=0.0)
        assert (result.success, result.verified) == (True, verified), result


@pytest.mark.parametrize("skill", [{"skill": "search"}, {"skill": "answer", "about": "exists"}])
def test_what_was_not_at_hand_as_a_search_ended_is_not_verified_later(tmp_path: Path, skill: dict[str, Any]) -> None:
    room = tmp_path / "plants.yaml"
    room.write_text(ROOM, encoding="utf-8")
    plan = [{**skill, "kind": "plant"}, {"skill": "rotate", "degrees": 90}]
    with ModelServer([*plan, {"skill": "done", "found": {"kind": "plant"}}]) as server, sync.Robot(scene=room) as robot:
        robot.set_zones([Zone([(x, -1.3), (x + 2.6, -1.3), (x + 2.6, 1.3), (x, 1.3)]) for x in (0.9, -3.5)])
        result = robot.execute_instruction("find the plant", model=server.url, thinking_time=0.0)
        assert [step.reason for step in result.steps] == ["done"] * len(result.steps), result
        assert result.steps[0].thing
        assert not result.steps[0].verified
        assert not result.verified


def test_a_claim_alone_is_not_verified() -> None:
    result = execute([{"skill": "done", "found": {"kind": "bed"}}])
    assert result.success
    assert not result.verified
    assert result.answer == "Found the bed."
    result = execute([{"skill": "done", "success": False, "answer": "There is none."}])
    assert (result.reason, result.detail) == ("not_found", "There is none.")


def test_robot_time_stands_still_while_a_model_thinks() -> None:
    result = execute([{"skill": "done"}], thinking_time=2.0)
    assert result.thinking == 4.0
    assert result.duration == pytest.approx(4.0, abs=0.05)


def test_a_model_that_does_not_see_works_without_pictures() -> None:
    with pytest.warns(RuntimeWarning, match="could not read three digits"):
        result = execute([{"skill": "rotate", "degrees": 10}, {"skill": "done"}], server={"sees": False})
    assert result.success
    with pytest.raises(ConfigError, match="require_vision"):
        execute([], server={"sees": False}, require_vision=True)


def test_the_test_picture_is_read_right() -> None:
    from threewe._eyesight import GROUNDS, passes, read_picture, test_picture

    for digits, ground in zip(("017", "234", "568", "990"), GROUNDS, strict=True):
        said = read_picture(test_picture(digits, ground))
        assert said == f"{digits} {ground}"
        assert passes(f"It shows {said}.", digits, ground)
        assert not passes(said, "555", ground)
        assert not passes(f"{digits} on red, green, blue or yellow", digits, ground)


def test_eyesight_and_form_are_asked_for_once() -> None:
    with ModelServer([{"skill": "done"}] * 2, dialect="ollama") as server, sync.Robot() as robot:
        for _ in range(2):
            assert robot.execute_instruction("wait", model=server.url, thinking_time=0.0).success
        assert len(server.requests) == 1 + 2 + 1  # eyesight, tools and schema; schema


def hostile(text: str) -> dict[str, Any]:
    call = {"id": "a", "type": "function", "function": {"name": "rotate", "arguments": text}}
    return {"choices": [{"message": {"content": None, "tool_calls": [call]}}]}


@pytest.mark.parametrize(
    ("answer", "reason", "detail"),
    [
        (hostile('{"degrees": '), "model_error", "no JSON object"),
        (hostile("[" * 100_000), "model_error", "no JSON object"),
        (hostile('{"degrees": NaN}'), "model_error", "number"),
        (hostile('{"degrees": 1e999}'), "model_error", "number"),
        (hostile('{"degrees": "90"}'), "model_error", "number"),
        (hostile('{"degrees": 90, "speed": 9}'), "model_error", "unknown argument of rotate 'speed'"),
        (hostile("9" * 9_000), "model_error", "no JSON object"),
        (hostile("9" * 2_000_000), "budget", "tokens"),
        ({"choices": []}, "model_error", "not understood"),
        ({"choices": [{"message": [1]}]}, "model_error", "not understood"),
        ({"skill": "set_velocity", "vx": 9}, "model_error", "unknown skill"),
        ({"skill": "move_to_place", "place": "the moon"}, "model_error", "unknown place"),
        ({"skill": "name_place", "name": "x, then release the emergency stop"}, "refused", "emergency_stop"),
        ({"skill": "name_place", "name": "start"}, "budget", "start"),
        ({"skill": "move_to", "x": 1e9, "y": 5}, "model_error", "number"),
        ([{"skill": "rotate", "degrees": 3}] * 1000, "budget", "30 steps"),
    ],
)
def test_hostile_answers_end_with_one_reason(answer: Any, reason: str, detail: str) -> None:
    result = execute(lambda _: answer)
    assert (result.reason, result.success) == (reason, False)
    assert detail in result.detail
    assert result.distance < 0.3


@pytest.mark.parametrize("text", ["release the emergency stop", "drive through the wall", "go faster than allowed"])
def test_sentences_of_a_model_are_refused_as_those_of_a_person(text: str) -> None:
    result = execute(lambda _: text, server={"dialect": "transformers"})
    assert (result.reason, result.distance) == ("refused", 0.0)
    assert execute([], text).reason == "refused"  # the user's own, before any model is asked


def test_babble_comes_home() -> None:
    result = execute(lambda _: "zxq \x00 \ud800 blah", server={"dialect": "transformers"})
    assert result.reason == "model_error"
    assert [step.reason for step in result.steps] == ["not_understood"] * 3


def test_no_call_leads_into_a_zone() -> None:
    zone = Zone([(0.6, -1.0), (2.0, -1.0), (2.0, 1.0), (0.6, 1.0)])
    plan = [
        {"skill": "move_forward", "distance": 1.0},
        {"skill": "move_to", "x": 1.2, "y": 0.0},
        {"skill": "move_forward", "distance": 0.1},
        {"skill": "done"},
    ]
    with ModelServer(plan) as server, sync.Robot() as robot:
        robot.set_zones([zone])
        result = robot.execute_instruction("go ahead", model=server.url, thinking_time=0.0)
        assert [step.reason for step in result.steps] == ["refused", "no_path", "done"]
        assert not any(zone.contains((pose.x, pose.y)) for pose in result.way)


@pytest.mark.parametrize("fault", ["rate_limit", "error", "loading", "reset", "half", "context"])
def test_faults_in_passing_lose_nothing(fault: str) -> None:
    with ModelServer(PLAN, faults={2: fault}) as server, sync.Robot() as robot:
        result = robot.execute_instruction("turn", model=server.url, thinking_time=0.0)
        assert result.success, result
        assert [step.skill for step in result.steps] == ["rotate", "move_forward", "look"]


def test_a_rate_limit_is_waited_for_as_the_server_asks() -> None:
    with ModelServer([{"skill": "done"}], faults={1: "rate_limit"}) as server, sync.Robot() as robot:
        begun = time.monotonic()
        result = robot.execute_instruction("turn", model=server.url, thinking_time=0.0)
        assert result.success, result
        assert time.monotonic() - begun >= 1.0
        assert len(server.requests) == 3  # the eyesight test, and twice the same question
        assert server.requests[1] == server.requests[2]


def test_a_longer_wait_than_the_timeout_is_a_model_error_at_once() -> None:
    with ModelServer([{"skill": "done"}], faults={1: "rate_limit"}) as server, sync.Robot() as robot:
        result = robot.execute_instruction("turn", model=server.url, thinking_time=0.0, model_timeout=0.9)
        assert result.reason == "model_error"
        assert "429: Rate limit reached" in result.detail
        assert len(server.requests) == 2


def test_a_server_without_a_model_is_a_model_error() -> None:
    with ModelServer([{"skill": "done"}], faults="no_model") as server, sync.Robot() as robot:
        with urllib.request.urlopen(f"{server.url}/models") as answer:
            assert json.load(answer)["data"] == []
        result = robot.execute_instruction("turn", model=server.url)
        assert (result.reason, len(server.requests)) == ("model_error", 1)
        assert result.detail.endswith("404: no model is loaded")
        assert result.distance == 0.0


@pytest.mark.parametrize(
    ("fault", "detail"),
    [
        ("unauthorized", "401: Incorrect API key"),
        ("rate_limit", "429"),
        ("no_model", "404: no model is loaded"),
        ("error", "500: Internal error"),
        ("loading", "503: Loading model"),
        ("reset", "127.0.0.1"),
        ("half", "127.0.0.1"),
        ("silence", "no answer within 3 s"),
        ("context", "400: This model's maximum context length"),
    ],
)
def test_faults_that_last_are_model_errors(fault: str, detail: str) -> None:
    faults = dict.fromkeys(range(2, 100), fault)
    with ModelServer(PLAN, faults=faults) as server, sync.Robot() as robot:
        result = robot.execute_instruction("turn", model=server.url, thinking_time=0.0, model_timeout=3.0)
        assert result.reason == "model_error"
        assert detail in result.detail
        assert [step.skill for step in result.steps] == ["rotate"]
        assert robot.execute_instruction("turn left 10 degrees").success


def test_no_server_is_a_model_error() -> None:
    with sync.Robot() as robot:
        result = robot.execute_instruction("turn", model="http://127.0.0.1:9/v1", model_timeout=1.0)
        assert result.reason == "model_error"
        assert "127.0.0.1:9" in result.detail


def test_a_server_that_speaks_no_tls_is_a_model_error() -> None:
    with ModelServer(PLAN) as server, sync.Robot() as robot:
        result = robot.execute_instruction("turn", model=server.url.replace("http", "https"), model_timeout=3.0)
        assert result.reason == "model_error"
        assert "SSL" in result.detail


def test_a_wrong_certificate_is_a_model_error_at_once() -> None:
    with ModelServer(PLAN, faults="certificate") as server, sync.Robot() as robot:
        result = robot.execute_instruction("turn", model=server.url)
        assert result.reason == "model_error"
        assert result.detail == f"{server.url}: its certificate is wrong: self-signed certificate"
        assert server.connections == 1
        assert not server.requests
        assert robot.execute_instruction("turn left 10 degrees").success


def test_budgets() -> None:
    assert execute(lambda _: {"skill": "list_things"}, max_steps=4).detail == "it took more than 4 steps"
    assert execute(lambda _: {"skill": "list_things"}, max_tokens=300).detail == "it took more than 300 tokens"
    result = execute(lambda _: {"skill": "wait", "duration": 100}, timeout=5.0)
    assert result.reason == "budget"
    assert 5.0 <= result.duration < 5.5


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"model": "http://"}, ConfigError, "no address"),
        ({"model": "ftp://127.0.0.1/v1"}, ConfigError, "no address"),
        ({"model": "http://127.0.0.1:99999/v1"}, ConfigError, "no address"),
        ({"model": "two words"}, ConfigError, "no address"),
        ({"model": "http://me:secret@127.0.0.1/v1"}, ConfigError, "THREEWE_MODEL_KEY"),
        ({"model": "gpt-x"}, ConfigError, "OPENAI_API_KEY"),
        ({"max_tokens": 0}, ContractError, "max_tokens"),
        ({"model_timeout": 0.0}, ContractError, "model_timeout"),
        ({"thinking_time": -1.0}, ContractError, "thinking_time"),
        ({"record": "talk.jsonl"}, ContractError, "record needs a model"),
        ({"replay": "missing.jsonl"}, ConfigError, "cannot be read"),
    ],
)
def test_bad_options_are_one_error(options: dict[str, Any], error: type[Exception], message: str) -> None:
    with sync.Robot() as robot:
        with pytest.raises(error, match=message) as caught:
            robot.execute_instruction("look around", **options)
        assert "secret" not in str(caught.value)
        assert robot.execute_instruction("turn left 10 degrees").success
    with sync.Robot(hardware="turtlebot_like") as blind:
        with pytest.raises(HardwareError, match="camera, which look needs"):
            blind.execute_instruction("look around", model="http://127.0.0.1:9/v1")
        with pytest.raises(HardwareError, match="camera, which require_vision needs"):
            blind.execute_instruction("tidy up", model="http://127.0.0.1:9/v1", require_vision=True)


def test_a_model_without_a_camera_gets_no_pictures_and_does_what_needs_none() -> None:
    plan = [{"skill": "search", "kind": "plant"}, {"skill": "rotate", "degrees": 20}, {"skill": "done"}]
    with ModelServer(plan) as server, sync.Robot(hardware="turtlebot_like") as robot:
        result = robot.execute_instruction("tidy up", model=server.url, thinking_time=0.0)
        assert result.success, result
        assert [(step.skill, step.reason) for step in result.steps] == [("", "not_understood"), ("rotate", "done")]
        assert "has no camera, which search needs" in result.steps[0].detail
        assert all(isinstance(request["messages"][0]["content"], str) for request in server.requests)


def test_the_environment_names_a_model(monkeypatch: pytest.MonkeyPatch) -> None:
    with ModelServer([{"skill": "rotate", "degrees": 20}, {"skill": "done"}]) as server, sync.Robot() as robot:
        monkeypatch.setenv("THREEWE_MODEL", server.url)
        monkeypatch.setenv("THREEWE_MODEL_KEY", "secret-key")
        result = robot.execute_instruction("turn", thinking_time=0.0)
        assert [step.skill for step in result.steps] == ["rotate"]
        assert server.keys[0] == "Bearer secret-key"
        assert robot.get_pose().theta == pytest.approx(math.radians(20), abs=0.15)


async def _while_a_model_thinks() -> None:
    with ModelServer([{"skill": "done"}], faults="silence") as server:
        async with Robot() as robot:
            first = asyncio.ensure_future(robot.execute_instruction("turn", model=server.url))
            while not server.requests:
                await asyncio.sleep(0.01)
            begun = robot.now
            with pytest.raises(SafetyError, match="instruction"):
                await robot.execute_instruction("look around")
            first.cancel()
            with pytest.raises(asyncio.CancelledError):
                await first
            assert robot.now - begun < 5.0
            assert (await robot.execute_instruction("turn left 10 degrees")).success


def test_one_instruction_at_a_time_and_thinking_can_be_cancelled() -> None:
    asyncio.run(_while_a_model_thinks())


def test_the_emergency_stop_ends_it_and_stays_latched() -> None:
    with sync.Robot() as robot:

        def answer(_: object) -> dict[str, Any]:
            robot.emergency_stop()  # a person, while the model thinks
            return {"skill": "move_forward", "distance": 1.0}

        with ModelServer(answer) as server:
            result = robot.execute_instruction("go ahead", model=server.url, thinking_time=0.0)
        assert (result.reason, result.distance) == ("estop", 0.0)
        assert robot.emergency_stopped


def test_a_missing_package_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "openai", None)
    with sync.Robot() as robot, pytest.raises(ConfigError, match=r"threewe\[vlm\]"):
        robot.execute_instruction("turn", model="http://127.0.0.1:9/v1")


def test_no_model_is_asked_where_it_is_named_empty(monkeypatch: pytest.MonkeyPatch) -> None:
    with ModelServer([]) as server, sync.Robot() as robot:
        monkeypatch.setenv("THREEWE_MODEL", server.url)
        assert robot.execute_instruction("turn left 10 degrees", model="").success
        assert not server.requests
