"""Where a recording goes: to a window, to browsers or to a file."""

from __future__ import annotations

import atexit
import os
import signal
import socket
import subprocess
import sys
import time
import webbrowser
from contextlib import suppress
from pathlib import Path
from urllib.parse import quote

import rerun as rr
from rerun.blueprint import Blueprint

from threewe._core import unknown_name
from threewe.errors import ConfigError

VIEWERS = ["rerun", "web", "network"]
LISTENS_ON = {"web": "127.0.0.1", "network": "0.0.0.0"}
PATIENCE = 20.0  # [s] of wall time for a server to begin


def check_sink(where: str) -> None:
    """Raises ConfigError for an unknown viewer, and for a window where there is no display."""
    if where not in VIEWERS and not where.endswith(".rrd"):
        raise ConfigError(f"{unknown_name('viewer', where, VIEWERS)} (a file to record ends in .rrd)")
    if where == "rerun" and not has_display():
        raise ConfigError(
            "viewer 'rerun' opens a window, and there is no display: "
            "'web' (--serve) serves browsers on this machine, 'run.rrd' (--save run.rrd) records"
        )


def has_display() -> bool:
    """Whether a window can be opened."""
    return sys.platform != "linux" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def open_recording(where: str, blueprint: Blueprint) -> rr.RecordingStream:
    """A new recording that goes to a window, to browsers or to a file."""
    recording = rr.RecordingStream("threewe")
    try:
        if where == "rerun":
            rr.spawn(recording=recording, executable_path=_executable(), default_blueprint=blueprint)
        elif where in LISTENS_ON:
            address = _serve(recording, blueprint, LISTENS_ON[where])
            print(f"Rerun viewer: {address}", flush=True)
            if where == "network":
                print("Everyone on the network can watch, without a password.", flush=True)
            if has_display():
                webbrowser.open(address)
        else:
            recording.save(where, default_blueprint=blueprint)
    except RuntimeError as error:  # such as a folder that is not there
        raise ConfigError(f"viewer '{where}': {error}") from error
    return recording


def _executable() -> str | None:
    """The viewer of this Python, which needs not be on the PATH; None leaves the search to Rerun."""
    path = Path(sys.executable).with_name("rerun")
    return str(path) if path.exists() else None


def _serve(recording: rr.RecordingStream, blueprint: Blueprint, interface: str) -> str:
    """The address for browsers. Rerun's own ports are used where they are free.

    The server is a process of its own, which ends with this one: in this process Rerun listens on all interfaces.
    """
    data, page = _free_port(9876), _free_port(9090)
    options = ["--bind", interface, "--port", str(data), "--web-viewer-port", str(page)]
    server = subprocess.Popen(
        [_executable() or "rerun", "--serve-web", *options],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,  # of the command and of what it starts itself
    )
    atexit.register(_end, server)
    _wait_for(server, data)
    _wait_for(server, page)
    source = f"rerun+http://localhost:{data}/proxy"
    recording.connect_grpc(f"rerun+http://127.0.0.1:{data}/proxy", default_blueprint=blueprint)
    return f"http://localhost:{page}?url={quote(source, safe='')}"


def _wait_for(server: subprocess.Popen[bytes], port: int) -> None:
    """Returns when a server answers at a port of this machine."""
    deadline = time.monotonic() + PATIENCE
    while server.poll() is None and time.monotonic() < deadline:
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) == 0:
                return
        time.sleep(0.02)
    _end(server)
    raise RuntimeError("Rerun's server does not begin: try `rerun --serve-web`")


def _end(server: subprocess.Popen[bytes]) -> None:
    with suppress(ProcessLookupError):
        os.killpg(server.pid, signal.SIGTERM)
    server.wait()


def _free_port(preferred: int) -> int:
    with socket.socket() as probe:
        try:
            probe.bind(("", preferred))
        except OSError:
            probe.bind(("", 0))
        port: int = probe.getsockname()[1]
        return port
