"""Mistyped keyword arguments get the nearest right name as an answer."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Mapping
from typing import ParamSpec, TypeVar

from threewe._core import unknown_name
from threewe.errors import ConfigError

P = ParamSpec("P")
R = TypeVar("R")


def known_options(function: Callable[P, R]) -> Callable[P, R]:
    """Lets a function raise ConfigError naming the nearest right option."""
    return known_options_but({})(function)


def known_options_but(elsewhere: Mapping[str, str]) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """The same, with hints for options that are another function's."""

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        names = [name for name in inspect.signature(function).parameters if name != "self"]

        @functools.wraps(function)
        def call(*args: P.args, **options: P.kwargs) -> R:
            for name in options:
                if name not in names:
                    raise ConfigError(elsewhere.get(name) or unknown_name("option", name, names))
            return function(*args, **options)

        return call

    return decorate
