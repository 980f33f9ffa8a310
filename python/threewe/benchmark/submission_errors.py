"""Errors of a submission, each in one line that says what to do. No token is ever in one."""

from __future__ import annotations

import http.client
import socket
import ssl

from threewe.errors import ConfigError, ConnectionError, ThreeweError

LONGEST = 200  # characters of what a server says


class NoAnswerError(Exception):
    """There was no connection, or it broke before an answer: trying again may help."""


def refusal(address: str, answer: http.client.HTTPResponse, size: int, token: str) -> ThreeweError:
    """What an answer that is not one of success means."""
    status = answer.status
    if 300 <= status < 400:
        there = printable(answer.getheader("Location", "another place"), token)
        return ConfigError(f"{address}: redirects to {there}: log in there if you trust it; the token stays here")
    known = {
        401: "a token is missing or wrong: set THREEWE_BENCHMARK_TOKEN to the one that the server gave you",
        403: "the token does not allow submissions here",
        413: f"a bundle of {size} bytes is more than the server takes: run fewer episodes",
    }
    if status in known:
        return ConfigError(f"{address}: {status}: {known[status]}")
    if status == 429:
        wait = printable(answer.getheader("Retry-After", ""), token)
        when = f"in {wait} s" if wait.isdigit() else "later"
        return ConnectionError(f"{address}: 429: too many submissions: try again {when}")
    reason = printable(answer.reason or "", token)
    if status >= 500:
        return ConnectionError(f"{address}: {status}: the server fails ({reason}): try again later")
    return ConfigError(f"{address}: {status} {reason}: no benchmark server, or it refuses the bundle")


def unreachable(address: str, error: Exception) -> Exception:
    """What broke a connection: `NoAnswerError` where trying again may help."""
    if isinstance(error, ssl.SSLCertVerificationError):
        return ConfigError(f"{address}: its certificate is not valid: {error.verify_message}")
    if isinstance(error, (ssl.SSLEOFError, ssl.SSLZeroReturnError)):
        return NoAnswerError(f"{address}: does not answer: the connection was closed")
    if isinstance(error, ssl.SSLError):
        return ConfigError(f"{address}: no encrypted connection: {error.reason or error}")
    if isinstance(error, socket.gaierror):
        return NoAnswerError(f"{address}: does not answer: {error.strerror}")
    if isinstance(error, http.client.HTTPException) and not isinstance(error, http.client.RemoteDisconnected):
        return ConfigError(f"{address}: what it answers is no HTTP")
    if isinstance(error, OSError) and str(error).startswith("Tunnel connection failed"):
        return ConfigError(f"{address}: the proxy of HTTPS_PROXY refuses: {printable(str(error), '')}")
    why = "timed out" if isinstance(error, TimeoutError) else getattr(error, "strerror", None) or "it hung up"
    return NoAnswerError(f"{address}: does not answer: {why}")


def printable(text: str, token: str) -> str:
    """The first line of what a server says, without the token and without what a terminal would act on."""
    clean = text.replace(token, "***") if token else text
    lines = clean.strip().splitlines() or [""]
    return "".join(letter for letter in lines[0] if letter.isprintable())[:LONGEST]
