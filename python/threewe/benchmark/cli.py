"""`threewe benchmark`: tasks, agents, results that can be replayed."""

from __future__ import annotations

import typer

from threewe.benchmark import cli_episodes

app = typer.Typer(help="Benchmarks: PointNav, ObjectNav, Exploration.", no_args_is_help=True, rich_markup_mode=None)
app.add_typer(cli_episodes.app, name="episodes")
