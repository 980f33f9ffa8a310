"""`threewe benchmark login` and `submit`: bundles go to a server, or are kept until there is one."""

from __future__ import annotations

import os
import shlex
from pathlib import Path
from typing import Annotated

import typer

from threewe._console import plain_console, styled
from threewe.errors import ConfigError, ConnectionError

console = plain_console()
complaints = plain_console(stderr=True)


def login(
    url: Annotated[str, typer.Argument(metavar="URL", help="Where bundles go: https://...")],
    unencrypted: Annotated[
        bool,
        typer.Option("--unencrypted", help="Take http:// to another machine: anyone on the way can read the token."),
    ] = False,
) -> None:
    """Keep the address of a benchmark server. The token is read from THREEWE_BENCHMARK_TOKEN, and never kept."""
    from threewe.benchmark.submission import TOKEN, save_server

    path = save_server(url, unencrypted=unencrypted)
    console.print(styled("bundles go to ", (url, "bold"), f", as {path} says"), soft_wrap=True)
    there = "is set" if os.environ.get(TOKEN) else "is not set: set it where you submit, if the server wants one"
    console.print(f"{TOKEN} {there}", soft_wrap=True)


def submit(
    bundle: Annotated[Path, typer.Argument(help="What `run --bundle` or `run --submit` wrote.")],
    timeout: Annotated[float, typer.Option(min=1.0, help="[s] for the bundle to be sent and answered.")] = 600.0,
) -> None:
    """Send a bundle to the server that `login` named."""
    from threewe.benchmark.submission import load_server, submit_bundle

    server = load_server()
    said = submit_bundle(bundle, server, timeout=timeout)
    where = server.address if server else ""
    console.print(
        styled("submitted: ", (str(bundle), "bold"), f" to {where}", f": {said}" if said else ""), soft_wrap=True
    )


def submit_or_keep(bundle: Path) -> None:
    """Submits what a run wrote; where that fails the bundle stays, and the error says how to send it later."""
    try:
        submit(bundle)
    except (ConfigError, ConnectionError) as error:
        complaints.print(styled(("not submitted: ", "bold red"), str(error)), soft_wrap=True, highlight=False)
        later = shlex.join(["threewe", "benchmark", "submit", str(bundle)])
        complaints.print(f"The bundle is kept: {bundle}. Send it later: {later}", soft_wrap=True, highlight=False)
        raise typer.Exit(1) from None
