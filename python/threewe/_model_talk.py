"""Conversation with a model, in robot time: each exchange is charged, may be recorded, and can be replayed."""

from __future__ import annotations

import hashlib
import json
import math
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from threewe._execution_result import Exchange
from threewe._model_client import ModelClient, ModelError, OverflowError, RejectedError, Reply
from threewe.errors import ConfigError, RecordingError

if TYPE_CHECKING:
    from threewe.robot import Robot

FORMAT = "threewe-talk/1"
ERRORS: dict[str, type[ModelError]] = {error.__name__: error for error in (ModelError, RejectedError, OverflowError)}

Recorded = dict[str, Any]


class Talk:
    """What asks a model, or a record of one, and adds up what that took."""

    def __init__(
        self, robot: Robot, source: ModelClient | Record, thinking_time: float | None, file: TextIO | None
    ) -> None:
        self._robot = robot
        self._source = source
        self._thinking_time = thinking_time
        self._file = file
        self.thinking = 0.0
        """[s] charged so far"""
        self.tokens = 0
        self.conversation: list[Exchange] = []

    async def ask(self, prompt: str, pictures: Sequence[bytes], form: str, most: int) -> Reply:
        """See `ModelClient.ask`. Robot time stands still meanwhile, then the time that it took goes by."""
        exchange: Recorded = {"form": form, "prompt": prompt, "pictures": [_digest(picture) for picture in pictures]}
        asked_at = self._robot.now
        thought = self._robot.thinking(0.0)
        reply: Reply | ModelError
        async with thought:
            if isinstance(self._source, Record):
                reply, seconds = self._source.take(exchange)
            else:
                begun = time.perf_counter()
                try:
                    reply = await self._source.ask(prompt, pictures, form, most)
                except ModelError as error:
                    reply = error
                measured = round(time.perf_counter() - begun, 6)
                seconds = measured if self._thinking_time is None else self._thinking_time
            self._write(exchange, reply, seconds)
            thought.charge(seconds)
        self.thinking += seconds
        failed = isinstance(reply, ModelError)
        tokens = reply.tokens if isinstance(reply, Reply) else 0
        said = Exchange(asked_at, seconds, prompt, tuple(pictures), _in_words(reply), failed, tokens)
        self.conversation.append(said)
        self.tokens += tokens
        if isinstance(reply, ModelError):
            raise reply
        return reply

    def _write(self, exchange: Recorded, reply: Reply | ModelError, seconds: float) -> None:
        if self._file is None:
            return
        if isinstance(reply, Reply):
            answer = {"text": reply.text, "calls": list(reply.calls), "tokens": reply.tokens}
        else:
            answer = {"error": type(reply).__name__, "message": str(reply)}
        write_line(self._file, {**exchange, "answer": answer, "seconds": seconds})


@contextmanager
def record_to(path: Path | None, head: Recorded) -> Iterator[TextIO | None]:
    """A file for a record, begun with its head. Raises RecordingError where it cannot be written."""
    if path is None:
        yield None
        return
    try:
        file = path.open("w", encoding="utf-8")
    except OSError as error:
        raise RecordingError(f"record: {path} cannot be written: {error.strerror}") from None
    with file:
        write_line(file, {"format": FORMAT, **head})
        yield file


def write_line(file: TextIO, value: Recorded) -> None:
    """One line of a record, at once: what is written stays when the program ends."""
    file.write(json.dumps(value) + "\n")
    file.flush()


class Record:
    """A recorded conversation."""

    def __init__(self, head: Recorded, exchanges: list[Recorded]) -> None:
        self.head = head
        self._exchanges = exchanges
        self._next = 0

    @staticmethod
    def load(path: Path) -> Record:
        """Of a file. Raises ConfigError."""
        try:
            content = path.read_bytes()
        except OSError as error:
            raise ConfigError(f"replay: {path} cannot be read: {error.strerror}") from None
        return Record.read(content, f"replay: {path}")

    @staticmethod
    def read(content: bytes, where: str) -> Record:
        """Of a file's content; `where` begins the message of the ConfigError for what is none."""
        try:
            values = [json.loads(line) for line in content.decode().splitlines()]
        except (ValueError, RecursionError):
            raise ConfigError(f"{where} is no record of a conversation: a line is no JSON") from None
        if not values or not isinstance(values[0], dict) or values[0].get("format") != FORMAT:
            raise ConfigError(f'{where} is no record of a conversation: its first line lacks "format": "{FORMAT}"')
        head: Recorded = values[0]
        for name, kind in {"instruction": str, "model": str, "form": str | None, "sees": bool | None}.items():
            if not isinstance(head.get(name), kind):
                raise ConfigError(f"{where}:1: {name} is missing, or of a wrong type")
        return Record(head, [_checked(value, f"{where}:{i}") for i, value in enumerate(values[1:], 2)])

    def take(self, exchange: Recorded) -> tuple[Reply | ModelError, float]:
        """The next answer and its seconds; an error where the robot asks something else than it did then."""
        number = self._next
        if number >= len(self._exchanges):
            return ModelError(f"the record has no more than {number} answers: the run differs"), 0.0
        recorded = self._exchanges[number]
        self._next += 1
        for name, value in exchange.items():
            if recorded[name] != value:
                return ModelError(f"answer {number + 1} of the record was to another {name}: the run differs"), 0.0
        answer = recorded["answer"]
        if "error" in answer:
            return ERRORS[answer["error"]](answer["message"]), recorded["seconds"]
        calls = tuple((name, arguments) for name, arguments in answer["calls"])
        return Reply(answer["text"], calls, answer["tokens"]), recorded["seconds"]


def _checked(value: Any, where: str) -> Recorded:
    """An exchange as it is written. Raises ConfigError."""
    try:
        answer = value["answer"]
        good = {"form", "prompt", "pictures"} <= value.keys() and 0.0 <= value["seconds"] < math.inf
        if "error" in answer:
            good = good and answer["error"] in ERRORS and isinstance(answer["message"], str)
        else:
            texts = [answer["text"], *(text for call in answer["calls"] for text in call)]
            good = good and all(isinstance(text, str) for text in texts) and isinstance(answer["tokens"], int)
            good = good and all(len(call) == 2 for call in answer["calls"])
    except (LookupError, TypeError, AttributeError):
        good = False
    if not good:
        raise ConfigError(f"{where}: no exchange with form, prompt, pictures, answer and seconds")
    exchange: Recorded = value
    return exchange


def _in_words(reply: Reply | ModelError) -> str:
    """What a model said, or what went wrong."""
    if isinstance(reply, ModelError):
        return str(reply)
    calls = [f"{name}({arguments})" for name, arguments in reply.calls]
    return "\n".join([reply.text, *calls] if reply.text else calls)


def _digest(picture: bytes) -> str:
    return hashlib.sha256(picture).hexdigest()[:16]
