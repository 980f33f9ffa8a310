"""Bundles go to a benchmark server, or are kept; every refusal is one line, and no token is ever in one."""

from __future__ import annotations

import base64
import hashlib
import shutil
import socket
import ssl
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import command_line
import pytest
from threewe import ConfigError, ConnectionError
from threewe.benchmark import Server, load_server, save_server, submit_bundle, write_bundle
from threewe.benchmark.submission import settings_file

SECRET = "t0ken-that-stays-here"
OPENSSL = shutil.which("openssl")


class Board:
    """A benchmark server on this machine: answers as it is asked to, and keeps what it was sent."""

    def __init__(self, answer: Callable[[BaseHTTPRequestHandler], None], context: ssl.SSLContext | None = None) -> None:
        board = self

        class Handler(BaseHTTPRequestHandler):
            def do_POST(self) -> None:
                board.headers.append(dict(self.headers))
                answer(self)

            def log_message(self, *_: object) -> None:
                pass

        class Quiet(ThreadingHTTPServer):
            def handle_error(self, *_: object) -> None:
                pass

        self.headers: list[dict[str, str]] = []
        self.bodies: list[bytes] = []
        self.server = Quiet(("127.0.0.1", 0), Handler)
        if context is not None:
            self.server.socket = context.wrap_socket(self.server.socket, server_side=True)
        self.port = self.server.server_address[1]
        self.address = f"{'https' if context else 'http'}://127.0.0.1:{self.port}/submissions"


@contextmanager
def board(answer: Callable[[BaseHTTPRequestHandler], None], context: ssl.SSLContext | None = None) -> Iterator[Board]:
    made = Board(answer, context)
    thread = threading.Thread(target=made.server.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True)
    thread.start()
    try:
        yield made
    finally:
        made.server.shutdown()
        made.server.server_close()
        thread.join()


def answers(status: int, body: bytes = b"", **headers: str) -> Callable[[BaseHTTPRequestHandler], None]:
    """A server that takes all and says this."""

    def answer(handler: BaseHTTPRequestHandler) -> None:
        handler.rfile.read(int(handler.headers["Content-Length"]))
        handler.send_response(status)
        for name, value in headers.items():
            handler.send_header(name.replace("_", "-"), value)
        handler.send_header("Content-Length", str(len(body)))
        handler.end_headers()
        handler.wfile.write(body)

    return answer


@pytest.fixture(autouse=True)
def user(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A configuration folder and a token of their own, and no proxy."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.setenv("THREEWE_BENCHMARK_TOKEN", SECRET)
    for name in ("http_proxy", "https_proxy", "HTTP_PROXY", "HTTPS_PROXY", "all_proxy", "ALL_PROXY"):
        monkeypatch.delenv(name, raising=False)
    return tmp_path / "config" / "threewe" / "benchmark.json"


@pytest.fixture
def bundle(tmp_path: Path) -> Path:
    outcome = {"replayed": {"commands": base64.b64encode(bytes(24 * 5000)).decode()}}
    write_bundle(tmp_path / "run.zip", {"format": "threewe-benchmark/1"}, [outcome])
    return tmp_path / "run.zip"


def command(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return command_line.threewe("benchmark", *arguments, cwd=folder)


def test_a_bundle_arrives_with_its_hash_and_the_token(bundle: Path) -> None:
    kept: list[bytes] = []

    def answer(handler: BaseHTTPRequestHandler) -> None:
        kept.append(handler.rfile.read(int(handler.headers["Content-Length"])))
        said = b'{"message": "queued as 17", "url": "https://board.example/17"}'
        handler.send_response(201)
        handler.send_header("Content-Length", str(len(said)))
        handler.end_headers()
        handler.wfile.write(said)

    with board(answer) as there:
        save_server(there.address)
        assert submit_bundle(bundle) == "queued as 17 https://board.example/17"
    assert kept == [bundle.read_bytes()]
    [headers] = there.headers
    assert headers["Authorization"] == f"Bearer {SECRET}"
    assert headers["Content-Type"] == "application/zip"
    digest = base64.b64encode(hashlib.sha256(kept[0]).digest()).decode()
    assert headers["Content-Digest"] == f"sha-256=:{digest}:"


def test_without_a_token_none_is_sent(bundle: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("THREEWE_BENCHMARK_TOKEN")
    with board(answers(204)) as there:
        assert submit_bundle(bundle, Server(there.address)) == ""
    assert "Authorization" not in there.headers[0]


@pytest.mark.parametrize(
    ("answer", "kind", "message"),
    [
        (answers(401), ConfigError, "401: a token is missing or wrong: set THREEWE_BENCHMARK_TOKEN"),
        (answers(403), ConfigError, "403: the token does not allow submissions"),
        (answers(404), ConfigError, "404 Not Found: no benchmark server"),
        (answers(413), ConfigError, r"413: a bundle of \d{6} bytes is more than the server takes"),
        (answers(429, Retry_After="90"), ConnectionError, "429: too many submissions: try again in 90 s"),
        (answers(429), ConnectionError, "try again later"),
        (answers(500), ConnectionError, "500: the server fails"),
        (answers(503), ConnectionError, "503: the server fails"),
        (answers(302, Location="https://other.example/"), ConfigError, "redirects to https://other.example/: log in"),
        (answers(307), ConfigError, "redirects to another place"),
    ],
)  # fmt: skip
def test_a_refusal_is_one_line_and_not_tried_again(
    answer: Callable[[BaseHTTPRequestHandler], None], kind: type[Exception], message: str, bundle: Path
) -> None:
    with board(answer) as there, pytest.raises(kind, match=message) as refused:
        submit_bundle(bundle, Server(there.address), waits=(0.0, 0.0))
    assert len(there.headers) == 1
    assert "\n" not in str(refused.value)
    assert SECRET not in str(refused.value)


def test_what_a_server_says_is_cut_down_to_a_line_without_the_token(bundle: Path) -> None:
    said = f"\x1b[31mhi {SECRET} \x07there{'!' * 500}\nand more".encode()
    with board(answers(200, said)) as there:
        line = submit_bundle(bundle, Server(there.address))
    assert line.startswith("[31mhi *** there!!!")
    assert len(line) <= 200
    assert line.isprintable()


def test_only_connections_that_fail_are_tried_again(bundle: Path) -> None:
    def hangs_up_twice(handler: BaseHTTPRequestHandler) -> None:
        if len(there.headers) < 3:
            handler.connection.shutdown(socket.SHUT_RDWR)
            return
        answers(200, b"there it is")(handler)

    with board(hangs_up_twice) as there:
        assert submit_bundle(bundle, Server(there.address), waits=(0.0, 0.0)) == "there it is"
    assert len(there.headers) == 3
    with pytest.raises(ConnectionError, match="does not answer: Connection refused"):
        submit_bundle(bundle, Server(there.address), waits=(0.0,))
    with pytest.raises(ConnectionError, match="does not answer"):
        submit_bundle(bundle, Server("https://no-such-host.invalid/"), waits=())


@pytest.mark.parametrize("how", ["silent", "a byte now and then"])
def test_a_server_that_takes_forever_is_left(how: str, bundle: Path) -> None:
    over = threading.Event()

    def answer(handler: BaseHTTPRequestHandler) -> None:
        while not over.wait(0.02):
            if how != "silent":
                handler.wfile.write(b"H")

    begun = time.monotonic()
    with board(answer) as there:
        try:
            with pytest.raises(ConnectionError, match=r"no answer within 0\.5 s"):
                submit_bundle(bundle, Server(there.address), timeout=0.5, waits=(0.0, 0.0))
        finally:
            over.set()
    assert len(there.headers) == 1, "the bundle may have arrived"
    assert time.monotonic() - begun < 60.0


def test_what_is_no_http_is_named(bundle: Path) -> None:
    def answer(handler: BaseHTTPRequestHandler) -> None:
        handler.rfile.read(int(handler.headers["Content-Length"]))
        handler.wfile.write(b"220 mail.example ESMTP\r\n")

    with board(answer) as there, pytest.raises(ConfigError, match="is no HTTP"):
        submit_bundle(bundle, Server(there.address))


@pytest.fixture(scope="module")
def certificate(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A certificate for 127.0.0.1 that signs itself, with its key."""
    if OPENSSL is None:
        pytest.skip("not shown: certificates are made by openssl, which is not here")
    folder = tmp_path_factory.mktemp("certificate")
    subprocess.run(
        [OPENSSL, "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=board",
         "-addext", "subjectAltName=IP:127.0.0.1", "-keyout", "key.pem", "-out", "certificate.pem"],
        cwd=folder, check=True, capture_output=True,
    )  # fmt: skip
    return folder


def encrypted(certificate: Path) -> ssl.SSLContext:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(certificate / "certificate.pem", certificate / "key.pem")
    return context


@pytest.mark.parametrize("is_encrypted", [False, True])
def test_a_server_may_refuse_and_hang_up_before_it_has_all(
    is_encrypted: bool, tmp_path: Path, certificate: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SSL_CERT_FILE", str(certificate / "certificate.pem"))
    outcome = {"replayed": {"commands": base64.b64encode(bytes(30_000_000)).decode()}}
    write_bundle(tmp_path / "large.zip", {"format": "threewe-benchmark/1"}, [outcome])

    def answer(handler: BaseHTTPRequestHandler) -> None:
        handler.send_error(413)
        handler.wfile.flush()
        handler.rfile.read(1_000_000)

    context = encrypted(certificate) if is_encrypted else None
    with board(answer, context) as there, pytest.raises(ConfigError, match="413: a bundle of 30000"):
        submit_bundle(tmp_path / "large.zip", Server(there.address), waits=())


def test_a_certificate_has_to_be_valid(bundle: Path, certificate: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with board(answers(200, b"thanks"), encrypted(certificate)) as there:
        with pytest.raises(ConfigError, match="its certificate is not valid: self-signed certificate"):
            submit_bundle(bundle, Server(there.address))
        with pytest.raises(ConfigError, match="its certificate is not valid"):
            submit_bundle(bundle, Server(there.address.replace("127.0.0.1", "localhost")))
        assert there.headers == [], "neither token nor bundle goes to it"
        monkeypatch.setenv("SSL_CERT_FILE", str(certificate / "certificate.pem"))
        assert submit_bundle(bundle, Server(there.address)) == "thanks"
    with board(answers(200)) as plain, pytest.raises(ConfigError, match="no encrypted connection"):
        submit_bundle(bundle, Server(plain.address.replace("http:", "https:")))


def test_a_proxy_sees_neither_token_nor_bundle(
    bundle: Path, certificate: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []

    class Proxy(BaseHTTPRequestHandler):
        def do_CONNECT(self) -> None:
            asked.append(f"{self.path} {dict(self.headers)}")
            if len(asked) == 1:
                self.send_error(407)
                return
            host, _, port = self.path.partition(":")
            with socket.create_connection((host, int(port))) as onward:
                self.send_response(200)
                self.end_headers()
                back = threading.Thread(target=pour, args=(onward, self.connection), daemon=True)
                back.start()
                pour(self.connection, onward)
                back.join()

        def log_message(self, *_: object) -> None:
            pass

    with board(answers(200, b"through it"), encrypted(certificate)) as there:
        proxy = ThreadingHTTPServer(("127.0.0.1", 0), Proxy)
        threading.Thread(target=proxy.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True).start()
        monkeypatch.setenv("https_proxy", f"http://me:secret@127.0.0.1:{proxy.server_address[1]}")
        monkeypatch.setenv("no_proxy", "")
        monkeypatch.setenv("SSL_CERT_FILE", str(certificate / "certificate.pem"))
        try:
            with pytest.raises(ConfigError, match="the proxy of HTTPS_PROXY refuses: Tunnel connection failed: 407"):
                submit_bundle(bundle, Server(there.address))
            assert submit_bundle(bundle, Server(there.address)) == "through it"
        finally:
            proxy.shutdown()
            proxy.server_close()
    assert asked[1].startswith(f"127.0.0.1:{there.port} ")
    assert base64.b64encode(b"me:secret").decode() in asked[1]
    assert SECRET not in "".join(asked)


def pour(source: socket.socket, target: socket.socket) -> None:
    while content := source.recv(65536):
        target.sendall(content)
    target.shutdown(socket.SHUT_WR)


@pytest.mark.parametrize(
    ("address", "message"),
    [
        ("http://board.example/x", "without encryption anyone on the way can read the token"),
        ("http://localhost.board.example/", "without encryption"),
        ("ftp://board.example", "begins with https://"),
        ("board.example", "begins with https://"),
        ("https://me:pa55word@board.example", "host and path alone"),
        ("https://board.example/?token=1", "host and path alone"),
        ("https://board.example:99999/", "Port out of range"),
        ("https://", "begins with https://"),
        ("https://board.example/a b", "expected an address such as"),
        ("https://board.example/\r\nHost: x", "expected an address such as"),
        ("https://[::1", "Invalid IPv6"),
    ],
)
def test_addresses_that_no_token_may_go_to_are_refused(address: str, message: str, user: Path) -> None:
    with pytest.raises(ConfigError, match=message) as refused:
        save_server(address)
    assert "pa55word" not in str(refused.value)
    assert not user.exists()


def test_the_address_is_kept_and_no_token(user: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert load_server() is None
    assert save_server("https://board.example/submissions") == user
    assert load_server() == Server("https://board.example/submissions")
    save_server("http://board.lan/", unencrypted=True)
    assert load_server() == Server("http://board.lan/", unencrypted=True)
    assert [path.name for path in user.parent.iterdir()] == ["benchmark.json"]
    assert SECRET not in user.read_text()
    monkeypatch.setenv("XDG_CONFIG_HOME", "relative")  # which the specification says to ignore
    assert settings_file() == Path.home() / ".config/threewe/benchmark.json"


@pytest.mark.parametrize(
    "content",
    ["", "[]", "{}", '{"server": 3, "unencrypted": false}', '{"server": "http://board.lan", "unencrypted": 1}',
     '{"server": "ftp://x", "unencrypted": false}', "[" * 100_000],
)  # fmt: skip
def test_settings_of_another_kind_are_named(content: str, user: Path) -> None:
    user.parent.mkdir(parents=True)
    user.write_text(content)
    with pytest.raises(ConfigError, match=r"benchmark\.json: .*login URL"):
        load_server()


def test_only_bundles_and_tokens_that_are_some_are_sent(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "other.zip").write_bytes(b"PK no zip at all")
    with board(answers(200)) as there:
        with pytest.raises(ConfigError, match="no bundle"):
            submit_bundle(tmp_path / "other.zip", Server(there.address))
        monkeypatch.setenv("THREEWE_BENCHMARK_TOKEN", "two lines\r\nX: y")
        with pytest.raises(ConfigError, match="THREEWE_BENCHMARK_TOKEN: expected printable") as refused:
            submit_bundle(tmp_path / "other.zip", Server(there.address))
    assert "two lines" not in str(refused.value)
    assert there.headers == []


def test_the_commands_send_keep_and_send_later(tmp_path: Path, user: Path) -> None:
    run = ("run", "pointnav", "--agent", "straight", "--scene", "apartment_v1", "--episodes", "1", "--submit")
    done = command(tmp_path, *run, "-o", "my run.json")
    assert done.returncode == 1
    assert "not submitted: server: none is known: `threewe benchmark login URL`" in done.stderr
    assert "The bundle is kept: my run.zip. Send it later: threewe benchmark submit 'my run.zip'" in done.stderr
    assert (tmp_path / "my run.zip").exists()
    assert (tmp_path / "my run.json").exists()

    with board(answers(200, b"rank 1")) as there:
        done = command(tmp_path, "login", there.address)
        assert done.returncode == 0, done.stderr
        assert done.stdout.splitlines()[0] == f"bundles go to {there.address}, as {user} says"
        assert SECRET not in done.stdout + user.read_text()
        done = command(tmp_path, "submit", "my run.zip")
        assert done.returncode == 0, done.stderr
        assert done.stdout == f"submitted: my run.zip to {there.address}: rank 1\n"
        done = command(tmp_path, *run, "--bundle", "other.zip")
        assert done.returncode == 0, done.stderr
        assert done.stdout.endswith(f"submitted: other.zip to {there.address}: rank 1\n")
        assert len(there.headers) == 2
    done = command(tmp_path, *run)
    assert done.returncode == 1
    assert "does not answer: Connection refused" in done.stderr
    assert "Send it later: threewe benchmark submit pointnav-straight.zip" in done.stderr
    done = command(tmp_path, "submit", "my run.zip")
    assert done.returncode == 2
    assert done.stderr == f"error: {there.address}: does not answer: Connection refused\n"


@pytest.mark.parametrize("arguments", [["--quick", "--agent", "straight"], ["--agent", "optimistic"]])
def test_what_has_no_log_is_not_submitted(arguments: list[str], tmp_path: Path) -> None:
    done: Any = command(tmp_path, "run", "pointnav", "--submit", *arguments)
    assert done.returncode == 2
    assert "neither a quick run nor a baseline has a log" in done.stderr
