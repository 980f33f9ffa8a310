"""Scripted OpenAI-compatible server on loopback, with the dialects and the failures of those that people run."""

from __future__ import annotations

import base64
import json
import socket
import ssl
import struct
import sys
import threading
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import TracebackType
from typing import Any, Self, cast

from threewe import _core
from threewe._model_skills import BadCallError, read_call, sentence
from threewe._wrong_certificate import wrong_context
from threewe.errors import ConfigError, ContractError

Answer = str | bytes | Mapping[str, Any] | list[Mapping[str, Any]]
"""What the model answers: a skill call `{"skill": "rotate", "degrees": 90}`, in the form that the dialect honours;
several at once; a text as it is; a whole body `{"choices": ...}`, or bytes that are none."""

PROSE = "I would look around first."


@dataclass(frozen=True)
class Dialect:
    """What a kind of server makes of a request."""

    tools: str  # honoured, ignored, or the status and message of the refusal
    response_format: str  # the same, or json_object where it honours no other
    models: str  # listed, empty, or error
    overflow: str  # its message when the context is too long


DIALECTS = {
    # platform.openai.com/docs/api-reference/chat
    "openai": Dialect("honoured", "honoured", "listed", "This model's maximum context length is 8192 tokens."),
    # without --jinja, its default until December 2025: github.com/containers/ramalama/issues/988, pull/2422
    "llama.cpp": Dialect(
        "500 tools param requires --jinja flag", "honoured", "listed", "the request exceeds the available context size"
    ),
    # docs.vllm.ai/en/latest/features/tool_calling: `required` is decoded by a grammar, whatever the model
    "vllm": Dialect("honoured", "honoured", "listed", "This model's maximum context length is 4096 tokens."),
    # a model without tools: github.com/ollama/ollama/issues/6027; `tool_choice` is ignored: issues/17921
    "ollama": Dialect("400 llava:latest does not support tools", "honoured", "listed", "context length exceeded"),
    # lmstudio.ai/docs/advanced/structured-output; a model without tools answers in text, no model loaded: none listed
    "lmstudio": Dialect("ignored", "honoured", "empty", "the context length is too short for this prompt"),
    # `python -m llama_cpp.server` 0.3.36, as we tried it: takes a schema in `json_object` alone
    "llama-cpp-python": Dialect("ignored", "json_object", "listed", "tokens exceed context window of 16384"),
    # `transformers serve` 5.23 and 5.24, as we tried them: ignores what it does not know, and fails to list
    "transformers": Dialect("ignored", "ignored", "error", "maximum context length exceeded"),
}
RETRY_AFTER = 1
"""[s] that a client is asked to wait by a rate limit."""
FAULTS = (
    "unauthorized",
    "rate_limit",
    "no_model",
    "error",
    "loading",
    "reset",
    "half",
    "silence",
    "context",
    "certificate",
)


class ModelServer:
    """A scripted model behind an OpenAI-compatible address on this machine, to test agents that use one.

    Use it as `with ModelServer(answers) as server:`, and give `server.url` as the model.

    Args:
        answers: what the model answers, one after the other, or a function of the request's body. Each is a skill
            call as `{"skill": "rotate", "degrees": 90}`, sent in the form that the dialect honours (tool, JSON or
            sentence); a list of such, at once; a text; a whole body `{"choices": [...]}`; or bytes. A request whose
            form the dialect ignores gets prose, and uses none of them up.
        dialect: openai, llama.cpp, llama-cpp-python, vllm, ollama, lmstudio or transformers.
        faults: what goes wrong, by the number of the request (from 0), or at each: unauthorized, rate_limit (for a
            second), no_model, error, loading, reset, half, silence, context; or, at each, certificate: it speaks TLS
            with a wrong one.
        sees: whether it reads the pictures of eyesight tests.

    Raises:
        ConfigError: an unknown dialect or fault, with the nearest right name.
    """

    def __init__(
        self,
        answers: Iterable[Answer] | Callable[[dict[str, Any]], Answer],
        *,
        dialect: str = "openai",
        faults: str | Mapping[int, str] | None = None,
        sees: bool = True,
    ) -> None:
        if dialect not in DIALECTS:
            raise ConfigError(_core.unknown_name("dialect", str(dialect), list(DIALECTS)))
        for fault in [faults] if isinstance(faults, str) else (faults or {}).values():
            if fault not in FAULTS:
                raise ConfigError(_core.unknown_name("fault", str(fault), FAULTS))
        if isinstance(faults, Mapping) and "certificate" in faults.values():
            raise ConfigError('faults: "certificate" is at each request or at none')
        if not callable(answers) and not isinstance(answers, Iterable):
            raise ContractError(f"answers must be a list or a function, got {answers!r}")
        self._next = answers if callable(answers) else _script(answers)
        self._dialect = DIALECTS[dialect]
        self._faults = faults
        self._sees = sees
        self._closing = threading.Event()
        self._lock = threading.Lock()
        self.requests: list[dict[str, Any]] = []
        """bodies of the chat requests that came, in order"""
        self.keys: list[str] = []
        """the `Authorization` that came with each"""
        self.connections = 0
        """how many were begun"""

    def __enter__(self) -> Self:
        self._server = _Server(("127.0.0.1", 0), _Handler)
        self._server.daemon_threads = True
        self._server.model = self  # type: ignore[attr-defined]
        if self._faults == "certificate":
            self._server.socket = wrong_context().wrap_socket(
                self._server.socket, server_side=True, do_handshake_on_connect=False
            )
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.02,), daemon=True)
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._closing.set()
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    @property
    def url(self) -> str:
        """Its base address, such as `http://127.0.0.1:40123/v1`."""
        scheme = "https" if self._faults == "certificate" else "http"
        return f"{scheme}://127.0.0.1:{self._server.server_address[1]}/v1"

    def _take(self, body: dict[str, Any], key: str) -> str | None:
        """Notes a chat request, and says which fault it meets."""
        with self._lock:
            number = len(self.requests)
            self.requests.append(body)
            self.keys.append(key)
        return self._faults if isinstance(self._faults, str) else (self._faults or {}).get(number)

    def _respond(self, body: dict[str, Any]) -> tuple[int, bytes]:
        """Status and body of the answer to a chat request."""
        if (picture := _eyesight(body)) is not None:
            return 200, _completion({"content": _read(picture) if self._sees else "I cannot see pictures."})
        form = "tools" if body.get("tools") else "response_format" if body.get("response_format") else "text"
        honoured = "honoured" if form == "text" else getattr(self._dialect, form)
        if honoured == "json_object":
            honoured = "honoured" if "schema" in body["response_format"] else "ignored"
        if honoured == "ignored":
            return 200, _completion({"content": PROSE})
        if honoured != "honoured":
            status, _, message = honoured.partition(" ")
            return int(status), _failure(message)
        try:
            with self._lock:
                answer = self._next(body)
        except StopIteration:
            return 400, _failure("the script has no more answers")
        if isinstance(answer, bytes):
            return 200, answer
        if isinstance(answer, Mapping) and "choices" in answer:
            return 200, json.dumps(answer).encode()
        return 200, _completion({"content": answer} if isinstance(answer, str) else _message(answer, form))


def _script(answers: Iterable[Answer]) -> Callable[[dict[str, Any]], Answer]:
    left = iter(list(answers))
    return lambda _: next(left)


def _message(answer: Mapping[str, Any] | list[Mapping[str, Any]], form: str) -> dict[str, Any]:
    """Calls of skills, in the form that was asked for."""
    calls = answer if isinstance(answer, list) else [answer]
    arguments = [{name: value for name, value in call.items() if name != "skill"} for call in calls]
    if form == "tools":
        functions = [
            {"name": call.get("skill"), "arguments": json.dumps(given)}
            for call, given in zip(calls, arguments, strict=True)
        ]
        made = [{"id": f"call_{i}", "type": "function", "function": f} for i, f in enumerate(functions)]
        return {"content": None, "tool_calls": made}
    if form == "response_format":
        return {"content": json.dumps(answer)}
    try:
        said = [sentence(read_call(call.get("skill"), given)) for call, given in zip(calls, arguments, strict=True)]
    except BadCallError:  # which no sentence says
        return {"content": json.dumps(answer)}
    return {"content": ", then ".join(said)}


def _completion(message: dict[str, Any]) -> bytes:
    usage = {"prompt_tokens": 100, "completion_tokens": 10, "total_tokens": 110}
    choice = {"index": 0, "message": {"role": "assistant", **message}, "finish_reason": "stop"}
    return json.dumps({"id": "chat", "object": "chat.completion", "choices": [choice], "usage": usage}).encode()


def _failure(message: str) -> bytes:
    return json.dumps({"error": {"message": message, "type": "invalid_request_error", "code": None}}).encode()


def _eyesight(body: dict[str, Any]) -> bytes | None:
    """The picture of an eyesight test, where the request is one."""
    from threewe._eyesight import QUESTION

    content = body["messages"][-1]["content"]
    if isinstance(content, str) or not any(part.get("text") == QUESTION for part in content):
        return None
    address: str = next(part["image_url"]["url"] for part in content if part["type"] == "image_url")
    return base64.b64decode(address.partition(",")[2])


def _read(picture: bytes) -> str:
    from threewe._eyesight import read_picture

    return read_picture(picture)


class _Server(ThreadingHTTPServer):
    def get_request(self) -> Any:
        """Counts them."""
        request = super().get_request()
        cast(ModelServer, self.model).connections += 1  # type: ignore[attr-defined]
        return request

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Says nothing of clients that hang up first."""
        if not isinstance(sys.exception(), (ConnectionError, ssl.SSLError)):
            super().handle_error(request, client_address)


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    @property
    def _model(self) -> ModelServer:
        return cast(ModelServer, self.server.model)  # type: ignore[attr-defined]

    def do_GET(self) -> None:
        listed = self._model._dialect.models
        if self.path != "/v1/models":
            return self._send(404, _failure("no such path"))
        if listed == "error":
            return self._send(500, b"Internal Server Error")
        without = self._model._faults == "no_model"
        names = [{"id": "scripted", "object": "model"}] if listed == "listed" and not without else []
        return self._send(200, json.dumps({"object": "list", "data": names}).encode())

    def do_POST(self) -> None:
        body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        if self.path != "/v1/chat/completions":
            return self._send(404, _failure("no such path"))
        fault = self._model._take(body, self.headers.get("Authorization", ""))
        match fault:
            case "unauthorized":
                return self._send(401, _failure("Incorrect API key provided"))
            case "rate_limit":
                return self._send(429, _failure("Rate limit reached"), {"Retry-After": str(RETRY_AFTER)})
            case "no_model":
                return self._send(404, _failure("no model is loaded"))
            case "error":
                return self._send(500, _failure("Internal error"))
            case "loading":
                return self._send(503, _failure("Loading model"))
            case "context":
                return self._send(400, _failure(self._model._dialect.overflow))
            case "reset":
                self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                return self._hang_up()
            case "silence":
                self._model._closing.wait(600.0)
                return self._hang_up()
            case "half":  # of an answer that uses up none of the script: the client asks again
                content = _completion({"content": PROSE})
                self._head(200, len(content), {})
                self.wfile.write(content[: len(content) // 2])
                return self._hang_up()
        return self._send(*self._model._respond(body))

    def _send(self, status: int, content: bytes, headers: Mapping[str, str] | None = None) -> None:
        self._head(status, len(content), headers or {})
        self.wfile.write(content)

    def _head(self, status: int, length: int, headers: Mapping[str, str]) -> None:
        self.send_response(status)
        for name, value in {"Content-Type": "application/json", "Content-Length": str(length), **headers}.items():
            self.send_header(name, value)
        self.end_headers()

    def _hang_up(self) -> None:
        self.close_connection = True
        self.wfile.flush()
        self.connection.close()

    def log_message(self, *_: object) -> None:
        """Says nothing: it is no server that people watch."""
