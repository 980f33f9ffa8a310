"""Submissions: a bundle goes to a benchmark server by one HTTP POST, and what the server says comes back.

The address is what `threewe benchmark login` stored; the token comes from THREEWE_BENCHMARK_TOKEN, is written nowhere,
and goes to that address alone: redirects are not followed.
"""

from __future__ import annotations

import base64
import hashlib
import http.client
import json
import os
import re
import socket
import ssl
import time
from collections.abc import Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from ipaddress import ip_address
from pathlib import Path
from threading import Event, Timer
from typing import TYPE_CHECKING
from urllib.parse import unquote, urlsplit
from urllib.request import getproxies, proxy_bypass

import threewe
from threewe._files import read_text
from threewe.benchmark.bundle import read_bundle
from threewe.benchmark.submission_errors import NoAnswerError, printable, refusal, unreachable
from threewe.errors import ConfigError, ConnectionError

if TYPE_CHECKING:
    from collections.abc import Iterator

TOKEN = "THREEWE_BENCHMARK_TOKEN"
CONNECT = 15.0  # [s] for a connection to come about
TIMEOUT = 600.0  # [s] for a bundle to be sent and answered
WAITS = (1.0, 4.0)  # [s] before it is tried again where there is no connection
LARGEST_ANSWER = 64 << 10  # [bytes] of what a server says
BLOCK = 64 << 10  # [bytes] that are sent at a time
SAFE = re.compile(r"[\x21-\x7e]{1,4096}")


@dataclass(frozen=True)
class Server:
    """Where bundles go."""

    address: str  # https://...
    unencrypted: bool = False  # http:// beyond this machine is meant so


def settings_file() -> Path:
    """Where the address is kept: `threewe/benchmark.json` in the user's configuration folder."""
    folder = Path(os.environ.get("XDG_CONFIG_HOME", ""))
    return (folder if folder.is_absolute() else Path.home() / ".config") / "threewe" / "benchmark.json"


def save_server(address: str, *, unencrypted: bool = False) -> Path:
    """Keeps an address for `submit_bundle`, and returns the file. Raises ConfigError for one that cannot be used."""
    require_address(address, unencrypted=unencrypted)
    path = settings_file()
    path.parent.mkdir(parents=True, exist_ok=True)
    written = path.with_suffix(f".{os.getpid()}.part")
    written.write_text(json.dumps({"server": address, "unencrypted": unencrypted}, indent=1) + "\n")
    written.replace(path)
    return path


def load_server() -> Server | None:
    """What `save_server` kept; None where it kept nothing. Raises ConfigError for a file that is none of its."""
    path = settings_file()
    if not path.exists():
        return None
    try:
        kept = json.loads(read_text(path))
        server = Server(kept["server"], kept["unencrypted"] is True)
        require_address(server.address, unencrypted=server.unencrypted)
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise ConfigError(f"{path}: {error}; `threewe benchmark login URL` writes it anew") from None
    return server


def require_address(address: str, *, unencrypted: bool = False) -> None:
    """Raises ConfigError for what is no address that a token may go to."""
    if not isinstance(address, str) or not SAFE.fullmatch(address):
        raise ConfigError("server: expected an address such as https://board.example/submissions")
    try:
        parts = urlsplit(address)
        host, _ = parts.hostname, parts.port
    except ValueError as error:
        raise ConfigError(f"server: {error}; expected an address such as https://board.example/submissions") from None
    if parts.scheme not in ("https", "http") or not host:
        raise ConfigError(f"server: {_named(address)}: expected an address that begins with https://")
    if parts.username is not None or parts.password is not None or parts.query or parts.fragment:
        raise ConfigError(f"server: expected host and path alone; the token comes from {TOKEN}")
    if parts.scheme == "http" and not unencrypted and not _is_this_machine(host):
        raise ConfigError(
            f"server: {address}: without encryption anyone on the way can read the token and change the bundle: "
            "use https://, or --unencrypted if that is meant"
        )


def submit_bundle(
    path: str | Path, server: Server | None = None, *, timeout: float = TIMEOUT, waits: Sequence[float] = WAITS
) -> str:
    """Sends a bundle, and returns the line that the server says.

    Only where no connection comes about, or one breaks before an answer, it is tried again: a server knows a bundle
    that it has by its hash.

    Args:
        path: what `write_bundle` wrote.
        server: where to; what `save_server` kept, where left out.
        timeout: [s] for one attempt to be sent and answered.
        waits: [s] before each further attempt.

    Raises:
        ConfigError: no server, no bundle, or one that the server refuses.
        ConnectionError: no connection, no answer, or a server that fails.
    """
    to = server or load_server()
    if to is None:
        raise ConfigError("server: none is known: `threewe benchmark login URL` says where bundles go")
    require_address(to.address, unencrypted=to.unencrypted)
    token = _token()
    path = Path(path)
    read_bundle(path)  # before the server refuses it
    content = path.read_bytes()
    for wait in (*waits, None):
        try:
            return _spoken(_posted(to.address, token, content, timeout), token)
        except NoAnswerError as error:
            if wait is None:
                raise ConnectionError(str(error)) from None
            time.sleep(wait)
    raise AssertionError


def _token() -> str:
    token = os.environ.get(TOKEN, "")
    if token and not SAFE.fullmatch(token):
        raise ConfigError(f"{TOKEN}: expected printable characters without spaces")
    return token


def _posted(address: str, token: str, content: bytes, timeout: float) -> bytes:
    """One attempt: the body of the answer, if it is one of success."""
    parts = urlsplit(address)
    headers = {
        "Host": parts.netloc,
        "User-Agent": f"threewe/{threewe.__version__}",
        "Content-Type": "application/zip",
        "Content-Length": str(len(content)),
        "Content-Digest": f"sha-256=:{base64.b64encode(hashlib.sha256(content).digest()).decode()}:",  # RFC 9530
        **({"Authorization": f"Bearer {token}"} if token else {}),
    }
    connection = _connection(address)
    try:
        with _network_errors(address):
            connection.connect()
        with _deadline(connection, address, timeout), _network_errors(address):
            connection.putrequest("POST", parts.path or "/", skip_host=True, skip_accept_encoding=True)
            for name, value in headers.items():
                connection.putheader(name, value)
            connection.endheaders()
            answer = _answer(connection, content)
            body = answer.read(LARGEST_ANSWER)
    finally:
        connection.close()
    if 200 <= answer.status < 300:
        return body
    raise refusal(address, answer, len(content), token)


def _answer(connection: http.client.HTTPConnection, content: bytes) -> http.client.HTTPResponse:
    """Sends the bundle. A server may answer and hang up before it has all of it: 413 is such an answer."""
    try:
        for place in range(0, len(content), BLOCK):
            connection.send(content[place : place + BLOCK])
    except (BrokenPipeError, ConnectionResetError, ssl.SSLEOFError) as error:
        with suppress(OSError, http.client.HTTPException):
            return connection.getresponse()
        raise error
    return connection.getresponse()


def _connection(address: str) -> http.client.HTTPConnection:
    """Through the proxy of the environment where there is one: encrypted, so that it sees neither token nor bundle."""
    parts = urlsplit(address)
    host = parts.hostname or ""
    if parts.scheme == "http":
        return http.client.HTTPConnection(host, parts.port, timeout=CONNECT)
    context = ssl.create_default_context()
    proxy = getproxies().get("https")
    if not proxy or proxy_bypass(host):
        return http.client.HTTPSConnection(host, parts.port, timeout=CONNECT, context=context)
    via = urlsplit(proxy if "://" in proxy else f"http://{proxy}")
    connection = http.client.HTTPSConnection(via.hostname or "", via.port or 80, timeout=CONNECT, context=context)
    headers = {}
    if via.username is not None:
        login = f"{unquote(via.username)}:{unquote(via.password or '')}".encode()
        headers["Proxy-Authorization"] = f"Basic {base64.b64encode(login).decode()}"
    connection.set_tunnel(host, parts.port or 443, headers)
    return connection


@contextmanager
def _deadline(connection: http.client.HTTPConnection, address: str, timeout: float) -> Iterator[None]:
    """Ends a connection that takes longer, also one that goes on with a byte now and then."""
    taken: socket.socket = connection.sock
    taken.settimeout(None)  # `end` wakes it up
    over = Event()

    def end() -> None:
        over.set()
        with suppress(OSError):
            socket.socket.shutdown(taken, socket.SHUT_RDWR)  # of TCP: TLS has a thread that is in it

    timer = Timer(timeout, end)
    timer.daemon = True
    timer.start()
    try:
        yield
    except Exception:
        if over.is_set():
            raise ConnectionError(f"{address}: no answer within {timeout:g} s") from None
        raise
    finally:
        timer.cancel()


@contextmanager
def _network_errors(address: str) -> Iterator[None]:
    try:
        yield
    except (OSError, http.client.HTTPException) as error:
        raise unreachable(address, error) from None


def _spoken(body: bytes, token: str) -> str:
    """The first line of an answer: plain text, or the `message` or `url` of a JSON object."""
    text = body.decode("utf-8", "replace")
    with suppress(ValueError, RecursionError):
        value = json.loads(text)
        if isinstance(value, dict):
            text = " ".join(str(value[name]) for name in ("message", "url") if isinstance(value.get(name), str))
    return printable(text, token)


def _named(address: str) -> str:
    """An address without what may be a password in it."""
    return address.rpartition("@")[2]


def _is_this_machine(host: str) -> bool:
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
