"""Mistyped keyword arguments get the nearest right name as an answer."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import ParamSpec, TypeVar

from threewe._core import unknown_name
from threewe.errors import ConfigError

P = ParamSpec("P")
R = TypeVar("R")


def known_options(function: Callable[P, R]) -> Callable[P, R]:
    """Lets a function raise ConfigError naming the nearest right option."""
    names = [name for name in inspect.signature(function).parameters if name != "self"]

    @functools.wraps(function)
    def call(*args: P.args, **options: P.kwargs) -> R:
        for name in options:
            if name not in names:
                raise ConfigError(unknown_name("option", name, names))
        return function(*args, **options)

    return call
