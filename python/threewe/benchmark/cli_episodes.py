"""`threewe benchmark episodes`: makes frozen sets of episodes, and checks that they follow from their definition."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from threewe._console import plain_console, styled
from threewe.benchmark import cli_commitments
from threewe.benchmark.episodes import digest, find_episodes, to_json

app = typer.Typer(help="Frozen sets of episodes.", no_args_is_help=True, rich_markup_mode=None)
for command in (cli_commitments.secret, cli_commitments.commit, cli_commitments.reveal):
    app.command()(command)
console = plain_console()

Secret = Annotated[
    Path | None, typer.Option("--secret", help="File with the secret that buildings of `generated` are drawn from.")
]


@app.command()
def make(
    name: Annotated[str, typer.Argument(help="Such as pointnav_val_v1: task, split (val, test, generated), version.")],
    output: Annotated[Path | None, typer.Option("--output", "-o", help="The file; NAME.json by default.")] = None,
    secret: Secret = None,
) -> None:
    """Draw a set of episodes: the same bytes on every machine. Takes minutes."""
    from threewe.benchmark.commitments import read_secret
    from threewe.benchmark.sampling import make_named

    made, columns = make_named(name, secret=read_secret(secret) if secret else None)
    path = output or Path(f"{name}.json")
    path.write_text(to_json(made, columns))
    for scene, names in made["lacking"].items():
        console.print(f"{scene} has too few of: {', '.join(names)}")
    console.print(styled((str(path), "bold"), f": {len(made['episodes'])} episodes, sha256 {digest(path)}"))


@app.command()
def scene(
    name: Annotated[str, typer.Argument(help="A scene of an episode: building-SEED, or such as office_v2_unseen.")],
    output: Annotated[Path | None, typer.Option("--output", "-o", help="The file; NAME.yaml by default.")] = None,
) -> None:
    """Write a scene that episodes are in and that is drawn when it is needed."""
    from threewe.benchmark.buildings import load_scene

    path = output or Path(f"{name}.yaml")
    path.write_text(load_scene(name).to_yaml(name))
    console.print(styled((str(path), "bold")))


@app.command()
def check(
    name: Annotated[str, typer.Argument(help="A set, by name or file.")],
    secret: Secret = None,
) -> None:
    """Draw a set anew and compare it, byte by byte."""
    from threewe.benchmark.commitments import read_secret
    from threewe.benchmark.sampling import make_named

    path = find_episodes(name)
    made, columns = make_named(path.stem, secret=read_secret(secret) if secret else None)
    there, wanted = path.read_bytes(), to_json(made, columns).encode()
    if there == wanted:
        console.print(styled((path.stem, "bold"), f": as drawn, {len(made['episodes'])} episodes"))
        return
    pairs = enumerate(zip(there, wanted, strict=False))
    same = next((i for i, pair in pairs if pair[0] != pair[1]), min(len(there), len(wanted)))
    line = 1 + wanted.count(b"\n", 0, same)
    console.print(styled((path.stem, "bold"), f": differs in line {line} from what is drawn"))
    raise typer.Exit(1)
