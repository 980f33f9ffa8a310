"""Records of conversations with a model: the same run without a server, and no key in any of them."""

import html
import json
from pathlib import Path
from typing import Any

import command_line
import pytest
from threewe import ExecutionResult, sync
from threewe.errors import ConfigError, RecordingError
from threewe.testing import ModelServer

pytest.importorskip("openai")
pytest.importorskip("PIL")

TEXT = "look for a chair"
PLAN = [
    {"skill": "rotate", "degrees": 40},
    {"skill": "fly"},
    {"skill": "move_forward", "distance": 0.3},
    {"skill": "done"},
]
KEY = "secret-key-123"


def same(result: ExecutionResult) -> tuple[object, ...]:
    """All that must be the same to the bit."""
    steps = [(step, step.picture.tobytes()) for step in result.steps]
    said = result.reason, result.detail, result.answer, result.thinking, result.tokens, result.duration
    return steps, said, [tuple(pose) for pose in result.way], result.things, result.conversation


@pytest.mark.parametrize("dialect", ["openai", "llama.cpp", "transformers"])
def test_a_replay_is_the_same_run_without_a_server(tmp_path: Path, dialect: str) -> None:
    plan: list[Any] = [call if call["skill"] != "fly" else "fly away" for call in PLAN]
    talk = tmp_path / "talk.jsonl"
    with ModelServer(plan, dialect=dialect, faults={1: "rate_limit"}) as server, sync.Robot() as robot:
        first = robot.execute_instruction(TEXT, model=server.url, record=talk)  # thinking as long as it takes
    assert first.success, first
    assert first.thinking > 0.0
    with sync.Robot() as robot:
        again = robot.execute_instruction(TEXT, replay=talk, record=tmp_path / "again.jsonl")
    assert same(again) == same(first)
    assert (tmp_path / "again.jsonl").read_bytes() == talk.read_bytes()


def test_a_page_shows_what_was_said_and_each_picture_once(tmp_path: Path) -> None:
    plan = [{"skill": "rotate", "degrees": 40}, "<b>fly</b>", {"skill": "done", "answer": "Here."}]
    with ModelServer(plan, faults={3: "unauthorized"}) as server, sync.Robot() as robot:
        result = robot.execute_instruction(TEXT, model=server.url, thinking_time=0.5)
    asked = result.conversation
    assert [exchange.failed for exchange in asked] == [False, False, False, True]  # of which the first is of eyesight
    assert asked[1].answer == 'rotate({"degrees": 40})'
    assert asked[2].answer == "<b>fly</b>"
    assert "401: Incorrect API key provided" in asked[3].answer
    assert [len(exchange.pictures) for exchange in asked] == [1, 1, 2, 3]
    assert [exchange.tokens for exchange in asked] == [110, 110, 110, 0]
    assert sum(exchange.seconds for exchange in asked) == result.thinking == 2.0
    assert asked[1].time == asked[0].time + 0.5

    result.save(tmp_path / "run.html")
    page = (tmp_path / "run.html").read_text(encoding="utf-8")
    talk = page.partition("<h2>Conversation with the model</h2>")[2]
    assert talk.count("<img") == 4  # the drawn one, and one of each look
    assert "and 2 that it had been sent before" in talk
    assert "&lt;b&gt;fly&lt;/b&gt;" in talk
    assert json.dumps(TEXT) in html.unescape(talk)
    assert "http:" not in page.replace(server.url, "")


def test_an_error_is_replayed_too(tmp_path: Path) -> None:
    talk = tmp_path / "talk.jsonl"
    with ModelServer(PLAN, faults={2: "unauthorized"}) as server, sync.Robot() as robot:
        first = robot.execute_instruction(TEXT, model=server.url, record=talk)
    assert first.reason == "model_error"
    with sync.Robot() as robot:
        assert same(robot.execute_instruction(TEXT, replay=talk)) == same(first)


def test_no_key_is_in_any_record_or_report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("THREEWE_MODEL_KEY", KEY)
    talk, page = tmp_path / "talk.jsonl", tmp_path / "page.html"
    for echo in ({"skill": "done", "answer": f"your key is {KEY}"}, f"key {KEY}"):
        with ModelServer([echo] * 5) as server, sync.Robot() as robot:
            result = robot.execute_instruction(TEXT, model=server.url, record=talk)
            assert server.keys[0] == f"Bearer {KEY}"
        result.save(page)
        assert "***" in str(result)
        assert KEY not in talk.read_text() + page.read_text() + str(result)


def test_a_run_that_differs_says_so(tmp_path: Path) -> None:
    talk = tmp_path / "talk.jsonl"
    with ModelServer(PLAN) as server, sync.Robot() as robot:
        robot.execute_instruction(TEXT, model=server.url, record=talk)
    with sync.Robot(seed=9) as robot:
        result = robot.execute_instruction(TEXT, replay=talk)
        assert result.reason == "model_error"
        assert "the run differs" in result.detail
        with pytest.raises(ConfigError, match="another instruction: 'look for a chair'"):
            robot.execute_instruction("look for a bed", replay=talk)
    lines = talk.read_text().splitlines(keepends=True)
    talk.write_text("".join(lines[:3]))  # as it is when a program ends early
    with sync.Robot() as robot:
        result = robot.execute_instruction(TEXT, replay=talk)
        assert (result.reason, len(result.steps)) == ("model_error", 1)
        assert "no more than 2 answers" in result.detail


HEAD = {"format": "threewe-talk/1", "instruction": TEXT, "model": "m", "form": None, "sees": None}
ANSWER = {"text": "a", "calls": [], "tokens": 1}
EXCHANGE = {"form": "tools", "prompt": "p", "pictures": [], "answer": ANSWER, "seconds": 1.0}


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([], "first line"),
        (["{"], "no JSON"),
        ([[1]], "first line"),
        ([{"format": "threewe-talk/9"}], "first line"),
        ([{**HEAD, "sees": 7}], ":1: sees"),
        ([HEAD, 5], ":2: no exchange"),
        ([HEAD, {**EXCHANGE, "seconds": -1.0}], ":2: no exchange"),
        ([HEAD, {**EXCHANGE, "seconds": "1"}], ":2: no exchange"),
        ([HEAD, {**EXCHANGE, "answer": {**ANSWER, "calls": [["a"]]}}], ":2: no exchange"),
        ([HEAD, EXCHANGE, {**EXCHANGE, "answer": {"error": "SystemExit", "message": ""}}], ":3: no exchange"),
    ],
)
def test_files_that_are_no_records_are_one_error(tmp_path: Path, lines: list[Any], message: str) -> None:
    talk = tmp_path / "talk.jsonl"
    talk.write_text("\n".join(line if isinstance(line, str) else json.dumps(line) for line in lines))
    with sync.Robot() as robot:
        with pytest.raises(ConfigError, match=message):
            robot.execute_instruction(TEXT, replay=talk)
        with ModelServer(PLAN) as server, pytest.raises(RecordingError, match="cannot be written"):
            robot.execute_instruction(TEXT, model=server.url, record=tmp_path / "missing" / "talk.jsonl")


def test_the_command_records_and_replays(tmp_path: Path) -> None:
    talk = str(tmp_path / "talk.jsonl")
    with ModelServer([PLAN[0], PLAN[3]]) as server:
        first = command_line.threewe("instruct", TEXT, "--model", server.url, "--record", talk)
    assert first.returncode == 0, first.stderr
    assert "a model thought for" in first.stdout
    again = command_line.threewe("instruct", TEXT, "--replay", talk)
    assert (again.returncode, again.stdout) == (0, first.stdout)
