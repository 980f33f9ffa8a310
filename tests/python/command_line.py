"""The command `threewe` in this process: a process of its own takes half a second of a processor to begin."""

from __future__ import annotations

import io
import subprocess
import sys
from contextlib import chdir, redirect_stderr, redirect_stdout
from pathlib import Path

import pytest
from threewe import cli


def threewe(*arguments: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Runs it in a folder, as far as its program would; the status, and what it wrote."""
    out, err = io.StringIO(), io.StringIO()
    command = ["threewe", *arguments]
    with pytest.MonkeyPatch.context() as patch, chdir(cwd or "."), redirect_stdout(out), redirect_stderr(err):
        patch.setattr(sys, "argv", command)
        status: str | int | None = 0
        try:
            cli.main()
        except SystemExit as end:
            status = end.code
    assert isinstance(status, int), status
    return subprocess.CompletedProcess(command, status, out.getvalue(), err.getvalue())
