"""The ROS 2 graph from the command line: `threewe ros2`."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.table import Column, Table

from threewe import _core
from threewe._console import plain_console

app = typer.Typer(help="Robots that speak ROS 2, without ROS 2 installed.", no_args_is_help=True, rich_markup_mode=None)


@app.command()
def discover(
    seconds: Annotated[float, typer.Option(min=0.1, max=60.0, help="How long to look.")] = 3.0,
) -> None:
    """List the topics that nodes publish or take, their types, distributions and quality of service.

    It searches this computer unless ROS_AUTOMATIC_DISCOVERY_RANGE or ROS_STATIC_PEERS ask for more, in ROS_DOMAIN_ID.
    """
    endpoints = [endpoint for endpoint in _core.ros2_discover(seconds) if endpoint.topic.startswith("/")]
    table = Table(
        Column("topic", overflow="fold"),
        Column("type", overflow="fold"),
        "publishers",
        "takers",
        "offered",
        Column("distribution", overflow="fold"),
    )
    for topic, kind in sorted({(endpoint.topic, endpoint.type) for endpoint in endpoints}):
        same = [endpoint for endpoint in endpoints if (endpoint.topic, endpoint.type) == (topic, kind)]
        publishers = [endpoint for endpoint in same if endpoint.publishes]
        table.add_row(
            topic,
            kind or "none of ROS 2",
            _names(publishers),
            _names([endpoint for endpoint in same if not endpoint.publishes]),
            ", ".join(sorted({_quality(endpoint) for endpoint in publishers})),
            ", ".join(sorted({_distribution(endpoint) for endpoint in same})),
        )
    console = plain_console()
    console.print(table)
    console.print(f"{len(endpoints)} publishers and subscriptions", highlight=False)


def _names(endpoints: list[_core.Ros2Endpoint]) -> str:
    """How many there are, and the nodes that said their names."""
    nodes = sorted({endpoint.node for endpoint in endpoints} - {""})
    return f"{len(endpoints)}" + (f" ({', '.join(nodes)})" if nodes else "") if endpoints else "-"


def _quality(endpoint: _core.Ros2Endpoint) -> str:
    kept = ", transient local" if endpoint.transient_local else ""
    return ("reliable" if endpoint.reliable else "best effort") + kept


def _distribution(endpoint: _core.Ros2Endpoint) -> str:
    """By the hash of its type."""
    if not endpoint.hash:
        return "humble or micro-ROS"
    names = _core.ros2_distributions_with(endpoint.type, endpoint.hash)
    return " or ".join(name for name in names if name != "humble") if names else "unknown type hash"
