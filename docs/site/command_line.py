"""The reference of the command `threewe`, from its own help."""

import subprocess
import sys


def page() -> str:
    """Every command with its options, as Markdown."""
    command = [
        sys.executable,
        "-m",
        "typer",
        "threewe.cli",
        "utils",
        "docs",
        "--name",
        "threewe",
        "--title",
        "Command line",
    ]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout
