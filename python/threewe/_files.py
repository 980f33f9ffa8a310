"""Files that others wrote: only regular ones are opened, and none is read that is larger than its format can be."""

from __future__ import annotations

from pathlib import Path

from threewe.errors import ConfigError

LARGEST_TEXT = 64 * 2**20
"""[bytes] of a text that is read at once."""


def require_file(path: Path) -> None:
    """Raises ConfigError unless a path is a regular file: a device or a pipe may never end."""
    try:
        found = path.is_file()
    except (OSError, ValueError) as error:  # a name that no file system takes
        raise ConfigError(f"{str(path)!r}: cannot be read: {error}") from None
    if not found:
        raise ConfigError(f"{path}: {'not a file' if path.exists() else 'no such file'}")


def read_text(path: Path) -> str:
    """A UTF-8 text. Raises ConfigError with file and place."""
    require_file(path)
    try:
        if path.stat().st_size > LARGEST_TEXT:
            raise ConfigError(f"{path}: larger than {LARGEST_TEXT} bytes")
        content = path.read_bytes()
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from None
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise ConfigError(f"{path}:{line}: expected UTF-8 text; save the file as that") from None
