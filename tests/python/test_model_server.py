"""The scripted server of models: what it makes of a request in each dialect, and how it fails."""

import http.client
import json
from contextlib import closing
from typing import Any

import pytest
from threewe.errors import ConfigError
from threewe.testing import ModelServer

TURN = {"skill": "rotate", "degrees": 90}


def ask(server: ModelServer, method: str = "POST", path: str = "/chat/completions", **body: Any) -> tuple[int, Any]:
    request = {"messages": [{"role": "user", "content": "go"}], **body}
    with closing(http.client.HTTPConnection(server.url.split("/")[2], timeout=5.0)) as connection:
        connection.request(method, "/v1" + path, json.dumps(request), {"Authorization": "Bearer none"})
        response = connection.getresponse()
        content = response.read()
    try:
        return response.status, json.loads(content)
    except ValueError:
        return response.status, content


@pytest.mark.parametrize(
    ("dialect", "tools", "response_format", "models"),
    [
        ("openai", 200, "json", 1),
        ("llama.cpp", 500, "json", 1),
        ("vllm", 200, "json", 1),
        ("ollama", 400, "json", 1),
        ("lmstudio", "prose", "json", 0),
        ("llama-cpp-python", "prose", "prose", 1),
        ("transformers", "prose", "prose", None),
    ],
)
def test_dialects(dialect: str, tools: int | str, response_format: str, models: int | None) -> None:
    with ModelServer([TURN, TURN, TURN], dialect=dialect) as server:
        status, listed = ask(server, "GET", "/models")
        assert (len(listed["data"]) if status == 200 else None) == models

        status, answer = ask(server, tools=[{}], tool_choice="required")
        if tools == "prose":
            assert answer["choices"][0]["message"]["content"].startswith("I would")
        else:
            assert status == tools
        if tools == 200:
            function = answer["choices"][0]["message"]["tool_calls"][0]["function"]
            assert (function["name"], json.loads(function["arguments"])) == ("rotate", {"degrees": 90})

        _, answer = ask(server, response_format={"type": "json_schema"})
        content = answer["choices"][0]["message"]["content"]
        assert content.startswith("I would") if response_format == "prose" else json.loads(content) == TURN

        if dialect == "llama-cpp-python":
            _, answer = ask(server, response_format={"type": "json_object", "schema": {}})
            assert json.loads(answer["choices"][0]["message"]["content"]) == TURN

        _, answer = ask(server)
        assert answer["choices"][0]["message"]["content"] == "turn left 90 degrees"
        assert len(server.requests) == 3 + (dialect == "llama-cpp-python")
        assert set(server.keys) == {"Bearer none"}


@pytest.mark.parametrize(
    ("fault", "status"),
    [("unauthorized", 401), ("rate_limit", 429), ("no_model", 404), ("error", 500), ("loading", 503), ("context", 400)],
)
def test_refusals_say_why_and_the_next_request_works(fault: str, status: int) -> None:
    with ModelServer([TURN], faults={0: fault}) as server:
        refused, answer = ask(server)
        assert refused == status
        assert answer["error"]["message"]
        assert ask(server)[0] == 200
        assert ask(server)[1]["error"]["message"] == "the script has no more answers"


def test_connections_break() -> None:
    with ModelServer([TURN, TURN, TURN], faults={0: "reset", 1: "half"}) as server:
        with pytest.raises(ConnectionError):
            ask(server)
        with pytest.raises((http.client.IncompleteRead, ConnectionError)):
            ask(server)
        assert ask(server)[0] == 200


def test_silence_ends_with_the_server() -> None:
    with (
        ModelServer([TURN], faults="silence") as server,
        closing(http.client.HTTPConnection(server.url.split("/")[2], timeout=0.2)) as connection,
    ):
        connection.request("POST", "/v1/chat/completions", json.dumps({"messages": [{"content": "go"}]}))
        with pytest.raises(TimeoutError):
            connection.getresponse()


def test_whole_bodies_and_several_calls() -> None:
    with ModelServer([b"<html>", {"choices": []}, [TURN, TURN]]) as server:
        assert ask(server) == (200, b"<html>")
        assert ask(server) == (200, {"choices": []})
        assert len(ask(server, tools=[{}])[1]["choices"][0]["message"]["tool_calls"]) == 2


def test_unknown_names_are_one_error() -> None:
    with pytest.raises(ConfigError, match="did you mean 'vllm'"):
        ModelServer([], dialect="vlm")
    with pytest.raises(ConfigError, match="did you mean 'reset'"):
        ModelServer([], faults={0: "rest"})
    with pytest.raises(ConfigError, match="at each request or at none"):
        ModelServer([], faults={0: "certificate"})
