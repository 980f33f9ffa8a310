"""The ROS 2 graph from the command line: `threewe ros2`."""

from __future__ import annotations

import re
import time
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Column, Table

from threewe import _core
from threewe._console import plain_console

app = typer.Typer(help="Robots that speak ROS 2, without ROS 2 installed.", no_args_is_help=True, rich_markup_mode=None)


@app.command()
def discover(
    seconds: Annotated[float, typer.Option(min=0.1, max=60.0, help="How long to look.")] = 3.0,
    robot: Annotated[str, typer.Option(help="Profile whose sensors topics are looked for.")] = "3we_standard_v2",
    write: Annotated[
        Path | None, typer.Option(help="A file to write: that profile, with a link to the topics that are used.")
    ] = None,
) -> None:
    """List the topics that nodes publish or take, and what a robot of a profile would use of them.

    It searches this computer unless ROS_AUTOMATIC_DISCOVERY_RANGE or ROS_STATIC_PEERS ask for more, in ROS_DOMAIN_ID.
    """
    profile = _core.RobotProfile.load(robot)
    graph = _core.ros2_discover(seconds)
    console = plain_console()
    if graph.silence:
        console.print(graph.silence, highlight=False)
        raise typer.Exit(1)
    proposal = _core.ros2_propose_link(profile, graph.endpoints)
    table = Table(
        Column("topic", overflow="fold"),
        Column("type", overflow="fold"),
        "publishers",
        "takers",
        "rate [Hz]",
        "offered",
        Column("distribution", overflow="fold"),
        Column("used as", overflow="fold"),
    )
    for use in proposal.topics:
        same = [endpoint for endpoint in graph.endpoints if (endpoint.topic, endpoint.type) == (use.topic, use.type)]
        publishers = [endpoint for endpoint in same if endpoint.publishes]
        table.add_row(
            use.topic,
            use.type or "none of ROS 2",
            _names(publishers),
            _names([endpoint for endpoint in same if not endpoint.publishes]),
            f"{publishers[0].rate:.1f}" if publishers and publishers[0].rate else "-",
            ", ".join(sorted({_quality(endpoint) for endpoint in publishers})),
            ", ".join(sorted({_distribution(endpoint) for endpoint in same})),
            use.sensor or f"none: {use.reason}",
        )
    console.print(table)
    console.print(f"{len(graph.endpoints)} publishers and subscriptions", highlight=False)
    if proposal.missing:
        console.print(f"without a topic: {', '.join(proposal.missing)}", highlight=False)
    if write is not None:
        rest = re.sub(r"^link:.*(\n[ \t#].*|\n(?=\n|[ \t]))*\n?", "", profile.yaml, flags=re.MULTILINE)
        write.write_text(f"{rest.rstrip()}\n\n{proposal.yaml}")
        console.print(f"written: {write}", highlight=False)


@app.command()
def serve(
    scene: Annotated[str, typer.Option(help="Name of a scene, or a file that ends in .yaml.")] = "office_v2",
    robot: Annotated[list[str] | None, typer.Option(help="Hardware profile; once for each robot.")] = None,
    namespace: Annotated[list[str] | None, typer.Option(help="Of each robot. [default: robot_1 ...]")] = None,
    noise: Annotated[str, typer.Option(help="realistic or ideal.")] = "realistic",
    seed: Annotated[int, typer.Option(min=0, help="Of all noise.")] = 0,
    speed: Annotated[float, typer.Option(help="Robot time over wall time; 0 is as fast as can be.")] = 1.0,
    lockstep: Annotated[bool, typer.Option("--lockstep", help="A command drives 20 ms, then time waits.")] = False,
    map: Annotated[bool, typer.Option("--map", help="Publish the scene's map, and map -> odom without error.")] = False,
    autonomy: Annotated[
        bool, typer.Option("--autonomy", help="Publish the robot's own map and plan, and drive to goal_pose.")
    ] = False,
    seconds: Annotated[float | None, typer.Option(min=0.0, help="Wall time until it ends. [default: never]")] = None,
) -> None:
    """Be a robot on ROS 2: the embedded simulator's sensors, transforms and clock, driven by cmd_vel.

    Nodes of this computer find it unless ROS_AUTOMATIC_DISCOVERY_RANGE or ROS_STATIC_PEERS ask for more, in
    ROS_DOMAIN_ID. They need use_sim_time. Ctrl-C ends it.
    """
    robots = robot or ["3we_standard_v2"]
    namespaces = namespace or ([""] if len(robots) == 1 else [f"robot_{i + 1}" for i in range(len(robots))])
    server = _core.ros2_serve(
        scene=scene,
        robots=robots,
        namespaces=[name if name.startswith("/") or not name else f"/{name}" for name in namespaces],
        noise=noise,
        seed=seed,
        speed=speed,
        lockstep=lockstep,
        map=map,
        autonomy=autonomy,
    )
    console = plain_console()
    console.print(f"serving {', '.join(robots)} in {scene}; Ctrl-C ends it", highlight=False)
    begin = time.monotonic()
    try:
        while seconds is None or time.monotonic() - begin < seconds:
            server.run(0.2)  # so that Ctrl-C is noticed
    except KeyboardInterrupt:
        pass
    wall = time.monotonic() - begin
    console.print(f"{server.now:.2f} s of robot time in {wall:.2f} s", highlight=False)


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
