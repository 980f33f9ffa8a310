"""Client of an OpenAI-compatible server: what it is asked, what came back, and what went wrong."""

from __future__ import annotations

import asyncio
import base64
import json
import os
import re
import ssl
import time
from collections.abc import Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self
from urllib.parse import urlsplit

from threewe._extras import needed_for
from threewe._model_skills import SKILLS, Skills, schema, tools
from threewe.errors import ConfigError

OPENAI = "https://api.openai.com/v1"
TRIES = 4  # of a request that fails in passing
PASSING = (408, 409, 429, 500, 502, 503, 504)  # statuses
LOADING = 503
LARGEST = 1_000_000  # [bytes] of an answer that is read


class ModelError(Exception):
    """The model or its server failed; the text says how."""


class RejectedError(ModelError):
    """The server does not take a request of this form."""


class OverflowError(ModelError):
    """The request was longer than the model's context."""


@dataclass(frozen=True)
class ModelAddress:
    """Where a model is."""

    url: str
    name: str
    """empty: the first that the server lists"""

    def __str__(self) -> str:
        return self.name if self.url == OPENAI else self.url + (f"#{self.name}" if self.name else "")

    @staticmethod
    def read(text: str) -> ModelAddress:
        """From a base URL, with `#NAME` for one of several models, or the name of a model at OpenAI."""
        if "://" not in text:
            if not re.fullmatch(r"[\w.:/-]{1,200}", text):
                raise ConfigError(
                    f"model: {text!r} is no address, such as http://127.0.0.1:8080/v1, and no model's name"
                )
            return ModelAddress(OPENAI, text)
        try:
            parts = urlsplit(text)
            good = parts.scheme in ("http", "https") and parts.hostname and (parts.port or 1) > 0
        except ValueError:
            good = False
        if not good:
            raise ConfigError(f"model: {text!r} is no address; one is http://127.0.0.1:8080/v1")
        if parts.username or parts.password or parts.query:
            raise ConfigError("model: an address has no user, password or query; a key comes from THREEWE_MODEL_KEY")
        return ModelAddress(f"{parts.scheme}://{parts.netloc}{parts.path}".rstrip("/"), parts.fragment)

    def key(self) -> str:
        """From the environment: OPENAI_API_KEY for OpenAI, THREEWE_MODEL_KEY for an address, which may need none."""
        name = "OPENAI_API_KEY" if self.url == OPENAI else "THREEWE_MODEL_KEY"
        key = os.environ.get(name, "").strip()
        if not key and self.url == OPENAI:
            raise ConfigError(f"model: {self.name} is at OpenAI, whose key is expected in {name}")
        return key or "none"


@dataclass(frozen=True)
class Reply:
    """What a model answered."""

    text: str
    calls: tuple[tuple[str, str], ...]
    """name and arguments, as they came"""
    tokens: int


class ModelClient:
    """A model at an address. Use it as `async with`."""

    def __init__(self, address: ModelAddress, timeout: float, skills: Skills = SKILLS) -> None:
        with needed_for("a model", "vlm"):
            import openai
        self._openai = openai
        self._address = address
        self._skills = skills
        self._key = address.key()
        self._timeout = timeout
        at_openai = address.url == OPENAI
        here = urlsplit(address.url).hostname in ("127.0.0.1", "::1", "localhost")
        self._client = openai.AsyncOpenAI(
            base_url=address.url,
            api_key=self._key,
            max_retries=0,
            timeout=timeout,
            # a server on this machine is not asked through a proxy, and none but OpenAI learns of an organization
            http_client=openai.DefaultAsyncHttpxClient(trust_env=False) if here else None,
            default_headers=None if at_openai else {"OpenAI-Organization": openai.omit, "OpenAI-Project": openai.omit},
        )
        self._limit = "max_completion_tokens" if at_openai else "max_tokens"
        self._name = address.name

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        await self._client.close()

    async def ask(self, prompt: str, pictures: Sequence[bytes], form: str, most: int) -> Reply:
        """Asks for an answer of at most so many tokens, in the form `tools`, `schema`, `object` or `text`.

        `object` is the schema as llama-cpp-python takes it.

        Tries again what fails in passing. Raises ModelError.
        """
        if not self._name:
            self._name = await self._first_model()
        images = [{"type": "image_url", "image_url": {"url": _data(picture)}} for picture in pictures]
        content: Any = [{"type": "text", "text": prompt}, *images] if images else prompt
        body: dict[str, Any] = {"messages": [{"role": "user", "content": content}], "model": self._name}
        body[self._limit] = most
        if form == "tools":
            body |= {"tools": tools(self._skills), "tool_choice": "required"}
        elif form == "schema":
            named = {"name": "call", "schema": schema(self._skills)}
            body["response_format"] = {"type": "json_schema", "json_schema": named}
        elif form == "object":
            body["response_format"] = {"type": "json_object", "schema": schema(self._skills)}
        return await self._send(body, form if form != "text" else "image" if pictures else "")

    async def _first_model(self) -> str:
        """The first that the server lists; a server that cannot list has one, whatever it is called."""
        try:
            listed = json.loads((await self._client.models.with_raw_response.list()).http_response.text)
            name = listed["data"][0]["id"]
            return name if isinstance(name, str) and name else "default"
        except self._openai.APIConnectionError as error:
            self._check_certificate(error)
            return "default"
        except (self._openai.OpenAIError, ValueError, LookupError, TypeError, RecursionError):
            return "default"

    async def _send(self, body: dict[str, Any], form: str) -> Reply:
        until = time.monotonic() + self._timeout
        for attempt in range(1_000_000):
            wait = min(0.2 * 2.0**attempt, 5.0)
            lasting = attempt >= TRIES - 1
            try:
                raw = await self._client.chat.completions.with_raw_response.create(**body)
                return self._reply(raw.http_response.text, body)
            except self._openai.APIStatusError as error:
                status, text = error.status_code, self._without_key(_message(error))
                if form and _is_about(form, text) and status != 429:
                    raise RejectedError(f"{status}: {text}") from None
                if status in (400, 413, 500) and re.search(r"(?i)context|too long|maximum.*length", text):
                    raise OverflowError(f"{self._address}: {status}: {text}") from None
                if status not in PASSING:
                    raise ModelError(f"{self._address}: {status}: {text}") from None
                failed = f"{status}: {text}"
                lasting = lasting and status != LOADING
                wait = _asked_wait(error) if status == 429 and _asked_wait(error) is not None else wait  # type: ignore[assignment]
            except self._openai.APITimeoutError:
                failed, lasting = f"no answer within {self._timeout:g} s", True
            except (self._openai.APIConnectionError, self._openai.APIResponseValidationError, ValueError) as error:
                self._check_certificate(error)
                failed = self._without_key(str(error.__cause__ or error))
            if lasting or time.monotonic() + wait > until:
                raise ModelError(f"{self._address}: {failed}")
            await asyncio.sleep(wait)
        raise ModelError(f"{self._address}: {failed}")

    def _check_certificate(self, error: BaseException) -> None:
        """Raises ModelError where that is wrong: no second try would help."""
        cause: BaseException | None = error
        while cause is not None and not isinstance(cause, ssl.SSLCertVerificationError):
            cause = cause.__cause__ or cause.__context__
        if cause is not None:
            raise ModelError(f"{self._address}: its certificate is wrong: {cause.verify_message}") from None

    def _reply(self, content: str, body: dict[str, Any]) -> Reply:
        """Out of a response's body. Raises ValueError where that is no JSON."""
        if len(content) > LARGEST:
            return Reply("", (), len(content) // 4)
        try:
            whole = json.loads(self._without_key(content))
        except RecursionError:
            raise ValueError("its answer is nested too deeply") from None
        message = _at(whole, "choices", 0, "message")
        text = _at(message, "content")
        calls = _at(message, "tool_calls")
        functions = [_at(call, "function") for call in calls] if isinstance(calls, list) else []
        made = [(str(_at(f, "name")), _as_text(_at(f, "arguments"))) for f in functions]
        tokens = _at(whole, "usage", "total_tokens")
        if isinstance(tokens, bool) or not isinstance(tokens, int) or not 0 < tokens < 10**9:
            tokens = (len(json.dumps(body)) + len(content)) // 4
        return Reply(text if isinstance(text, str) else "", tuple(made), tokens)

    def _without_key(self, text: str) -> str:
        return text.replace(self._key, "***") if self._key != "none" else text


def _at(value: Any, *way: str | int) -> Any:
    """What stands at a place in JSON; None where there is none."""
    for part in way:
        try:
            value = value[part]
        except (LookupError, TypeError):
            return None
    return value


def _as_text(arguments: Any) -> str:
    return arguments if isinstance(arguments, str) else json.dumps(arguments if arguments is not None else {})


def _data(picture: bytes) -> str:
    kind = "png" if picture.startswith(b"\x89PNG") else "jpeg"
    return f"data:image/{kind};base64,{base64.b64encode(picture).decode()}"


def _message(error: Any) -> str:
    """What the server said, in one line."""
    try:
        said = json.loads(error.response.text)
        said = _at(said, "error", "message") or _at(said, "error") or _at(said, "message") or error.response.text
    except (ValueError, RecursionError):
        said = error.response.text
    return " ".join(str(said).split())[:300]


def _is_about(form: str, text: str) -> bool:
    """Whether a refusal is one of the form of a request."""
    words = {
        "tools": r"tool|function",
        "schema": r"response_format|json_schema|schema|grammar|structured",
        "object": r"response_format|json_object|schema|grammar|structured",
        "image": r"image|vision|multimodal|mmproj|content.*(string|type)",
    }
    return re.search(f"(?i){words[form]}", text) is not None


def _asked_wait(error: Any) -> float | None:
    """[s] of `Retry-After`, at most 30."""
    try:
        return min(max(float(error.response.headers.get("retry-after", "")), 0.0), 30.0)
    except ValueError:
        return None
