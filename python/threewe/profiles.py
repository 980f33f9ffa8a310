"""The commands `threewe hardware ...`: robot profiles, and the autonomy parameters that follow from them."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.table import Column, Table

import threewe
from threewe._console import plain_console, styled

app = typer.Typer(
    help="Robot profiles: those that come with 3we, and your own.", no_args_is_help=True, rich_markup_mode=None
)
console = plain_console()
WIDE = 160  # characters of a table of parameters that goes to a file

SENSORS = ("lidar", "imu", "ultrasonics", "camera")


@app.command("list")
def list_profiles() -> None:
    """The robots, also those in folders that THREEWE_PATH names."""
    table = Table(Column("robot", no_wrap=True), "drive", "limits", "sensors", Column("description", overflow="fold"))
    broken = False
    for name in threewe.profile_names():
        try:
            profile = threewe.RobotProfile.load(name)
        except threewe.ConfigError as error:
            table.add_row(name, styled(("broken", "bold red")), "", "", str(error))
            broken = True
            continue
        table.add_row(
            name, drive_of(profile), limits_of(profile.operating_limits), sensors_of(profile), profile.description
        )
    console.print(table)
    if broken:
        raise typer.Exit(1)


@app.command("show")
def show_profile(
    name: Annotated[str, typer.Argument(help="Its name, or a file that ends in .yaml.")],
    parameters: Annotated[
        bool,
        typer.Option("--parameters", help="Every parameter of the autonomy stack, and where its value comes from."),
    ] = False,
    only: Annotated[str, typer.Option(help="With --parameters: those with this text in their names.")] = "",
) -> None:
    """What a robot is, and with --parameters what its autonomy stack makes of that."""
    profile = threewe.RobotProfile.load(name)
    if parameters:
        wide = console if console.is_terminal else plain_console(width=WIDE)
        wide.print(parameter_table(profile, only))
        return
    corners = profile.footprint
    length, width = (max(axis) - min(axis) for axis in zip(*corners, strict=True))
    table = Table("", "", show_header=False)
    table.add_row("robot", profile.name)
    table.add_row("description", profile.description)
    table.add_row(
        "body", f"{1000 * length:.0f} x {1000 * width:.0f} x {1000 * profile.height:.0f} mm, {profile.mass:g} kg"
    )
    table.add_row("drive", drive_of(profile))
    table.add_row("hardware limits", limits_of(profile.hardware_limits))
    table.add_row("operating limits", limits_of(profile.operating_limits))
    table.add_row("sensors", sensors_of(profile))
    console.print(table)


def parameter_table(profile: threewe.RobotProfile, only: str = "") -> Table:
    """The parameters whose names contain a text, one a row."""
    table = Table(
        Column("parameter", no_wrap=True),
        Column("value", justify="right"),
        Column("unit", no_wrap=True),
        Column("origin", no_wrap=True),
        Column("meaning", overflow="fold"),
    )
    for one in profile.parameters():
        if only in one.name:
            table.add_row(one.name, f"{one.value:.4g}", one.unit, one.origin, one.meaning)
    return table


def drive_of(profile: threewe.RobotProfile) -> str:
    """How its wheels move it."""
    return profile.kinematics.name


def limits_of(limits: threewe.Limits) -> str:
    """Linear and angular."""
    return f"{limits.linear:g} m/s, {limits.angular:g} rad/s"


def sensors_of(profile: threewe.RobotProfile) -> str:
    """The names of those that it has; all have wheel odometry."""
    return ", ".join([*(name for name in SENSORS if getattr(profile, name) is not None), "odometry"])
