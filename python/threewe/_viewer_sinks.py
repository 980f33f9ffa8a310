"""Where a recording goes: to a window, to browsers or to a file."""

from __future__ import annotations

import os
import socket
import sys
from pathlib import Path
from urllib.parse import quote

import rerun as rr
from rerun.blueprint import Blueprint

from threewe._core import unknown_name
from threewe.errors import ConfigError

VIEWERS = ["rerun", "web"]


def check_sink(where: str) -> None:
    """Raises ConfigError for an unknown viewer, and for a window where there is no display."""
    if where not in VIEWERS and not where.endswith(".rrd"):
        raise ConfigError(f"{unknown_name('viewer', where, VIEWERS)} (a file to record ends in .rrd)")
    if where == "rerun" and not has_display():
        raise ConfigError(
            "viewer 'rerun' opens a window, and there is no display: "
            "'web' (--serve) serves browsers, 'run.rrd' (--save run.rrd) records"
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
        elif where == "web":
            print(f"Rerun viewer: {_serve(recording, blueprint)}", flush=True)
        else:
            recording.save(where, default_blueprint=blueprint)
    except RuntimeError as error:  # such as a folder that is not there
        raise ConfigError(f"viewer '{where}': {error}") from error
    return recording


def _executable() -> str | None:
    """The viewer of this Python, which needs not be on the PATH; None leaves the search to Rerun."""
    path = Path(sys.executable).with_name("rerun")
    return str(path) if path.exists() else None


def _serve(recording: rr.RecordingStream, blueprint: Blueprint) -> str:
    """The address for browsers. Rerun's own ports are used where they are free."""
    data = recording.serve_grpc(grpc_port=_free_port(9876), default_blueprint=blueprint)
    port = _free_port(9090)
    rr.serve_web_viewer(web_port=port, connect_to=data, open_browser=has_display())
    return f"http://localhost:{port}?url={quote(data, safe='')}"


def _free_port(preferred: int) -> int:
    with socket.socket() as probe:
        try:
            probe.bind(("", preferred))
        except OSError:
            probe.bind(("", 0))
        port: int = probe.getsockname()[1]
        return port
