"""Packages that only some users need: where one is missing, one error names the extra that brings it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from threewe.errors import ConfigError


@contextmanager
def needed_for(what: str, extra: str) -> Iterator[None]:
    """Raises ConfigError, naming the extra, where an import inside fails."""
    try:
        yield
    except ImportError as missing:
        message = f'{what}: {missing}; install or update what it needs: pip install "threewe[{extra}]"'
        raise ConfigError(message) from missing
