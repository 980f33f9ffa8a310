"""Errors of the Hub as one line that says what to do. No token is ever in one."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from threewe.errors import ConfigError, ConnectionError, ThreeweError

HOW_TO_LOG_IN = "run `hf auth login`, or set HF_TOKEN"


@contextmanager
def hub_errors(repo_id: str, deed: str, again: str, what: str = "dataset") -> Iterator[None]:
    """Turns what `huggingface_hub` raises into our errors.

    Args:
        repo_id: as the user gave it.
        deed: what was being done: `pushing` or `pulling`.
        again: what the user can do when it broke off.
        what: is in the repository.

    Raises:
        ConfigError: the server refused.
        ConnectionError: the server could not be reached, or broke off.
    """
    try:
        yield
    except ThreeweError:
        raise
    except Exception as error:
        raise _translated(error, repo_id, deed, again, what) from None


def not_a_repo_id(repo_id: str) -> ConfigError:
    """The error for a repository id that is none."""
    return ConfigError(f"'{repo_id}' is no repository id: it must be user/name, of letters, digits, '-', '_' and '.'")


def _translated(error: Exception, repo_id: str, deed: str, again: str, what: str) -> ThreeweError:
    """Looks through the errors that caused it: uploads are wrapped by the threads that made them."""
    from huggingface_hub.errors import HfHubHTTPError, HFValidationError, OfflineModeIsEnabled, RevisionNotFoundError

    for cause in _causes(error):
        if isinstance(cause, HFValidationError):
            return not_a_repo_id(repo_id)
        if isinstance(cause, OfflineModeIsEnabled):
            return ConfigError(f"{deed} '{repo_id}': HF_HUB_OFFLINE is set; unset it")
        if isinstance(cause, RevisionNotFoundError):
            return ConfigError(f"'{repo_id}' has no such revision")
        if isinstance(cause, HfHubHTTPError):
            return _of_status(cause.response.status_code, repo_id, deed, again, what)
        if _is_network(cause):
            return ConnectionError(f"{deed} '{repo_id}': no connection to {_server()}, or it broke off: {again}")
        if isinstance(cause, OSError) and cause.strerror:
            where = f"{cause.filename}: " if cause.filename else ""
            return ConfigError(f"{deed} '{repo_id}': {where}{cause.strerror}")
    root = list(_causes(error))[-1]
    return ConnectionError(f"{deed} '{repo_id}' failed ({type(root).__name__}): {again}")


def _of_status(status: int, repo_id: str, deed: str, again: str, what: str) -> ThreeweError:
    if status == 401:
        # The Hub answers 401 also for what an anonymous caller must not know of.
        return ConfigError(f"{deed} '{repo_id}': the token is missing, wrong or expired: {HOW_TO_LOG_IN}")
    if status == 403:
        return ConfigError(f"{deed} '{repo_id}': the token does not allow it; it needs the right to write for pushing")
    if status == 404:
        return ConfigError(f"{deed} '{repo_id}': there is no such {what}, or it is private: {HOW_TO_LOG_IN}")
    if status == 429 or status >= 500:
        return ConnectionError(f"{deed} '{repo_id}': the server answers {status}: {again}")
    return ConfigError(f"{deed} '{repo_id}': the server refuses it ({status})")


def _causes(error: BaseException) -> Iterator[BaseException]:
    seen: set[int] = set()
    following: BaseException | None = error
    while following is not None and id(following) not in seen:
        seen.add(id(following))
        yield following
        following = following.__cause__ or following.__context__


def _is_network(error: BaseException) -> bool:
    """Whether it is one of the HTTP client's: httpx, or httpx2 in newer versions of `huggingface_hub`."""
    names = {f"{kind.__module__.partition('.')[0]}.{kind.__name__}" for kind in type(error).__mro__}
    ours = {"httpx.TransportError", "httpx2.TransportError", "builtins.ConnectionError", "builtins.TimeoutError"}
    return not names.isdisjoint(ours)


def _server() -> str:
    return os.environ.get("HF_ENDPOINT", "https://huggingface.co")
