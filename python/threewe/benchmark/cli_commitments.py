"""`threewe benchmark episodes secret`, `commit` and `reveal`: a held-out split as hashes, until it is retired."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from threewe._console import plain_console, styled
from threewe.benchmark.progress import progress
from threewe.errors import ConfigError

console = plain_console()

SecretFile = Annotated[Path, typer.Argument(metavar="SECRET", help="File with the secret.")]


def secret(file: Annotated[Path, typer.Argument(metavar="SECRET", help="The file to write; keep it safe.")]) -> None:
    """Draw a secret for a held-out split into a file that only you can read, and print its hash."""
    from threewe.benchmark.commitments import new_secret

    hashed = new_secret(file)
    console.print(styled((str(file), "bold"), f": secret with SHA-256 {hashed}"), soft_wrap=True)


def commit(
    file: SecretFile,
    output: Annotated[Path, typer.Option("--output", "-o", help="What is to be published: hashes alone.")],
    sets: Annotated[
        Path | None, typer.Option(help="Folder for the sets that the secret leads to, which are not to be published.")
    ] = None,
) -> None:
    """Draw the sets of `generated`, and write the hashes of secret and sets. Takes minutes."""
    from threewe.benchmark.commitments import commit as commit_to
    from threewe.benchmark.commitments import to_text

    drawn, texts = _draw(file)
    if sets is not None:
        sets.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            (sets / f"{name}.json").write_text(text)
    commitment = commit_to(drawn, texts)
    output.write_text(to_text(commitment))
    console.print(styled((str(output), "bold"), f": commits to {', '.join(texts)}"), soft_wrap=True)


def reveal(
    file: SecretFile,
    commitment: Annotated[str, typer.Option(help="Which, by name or file.")] = "generated_v1",
    draw: Annotated[
        bool, typer.Option("--draw", help="Also draw its sets anew and compare their hashes. Takes minutes.")
    ] = False,
) -> None:
    """Check a secret that is revealed against what was published before."""
    from threewe.benchmark.commitments import hash_of, load_commitment, read_secret
    from threewe.benchmark.commitments import reveal as check

    published = load_commitment(commitment)
    try:
        check(read_secret(file), published)
        if draw:
            _, texts = _draw(file)
            for name, wanted in published.sets.items():
                if name not in texts or hash_of(texts[name]) != wanted:
                    raise ConfigError(f"{published.name}: {name} is not drawn as it was committed to")
    except ConfigError as error:
        console.print(styled(("refused: ", "bold red"), str(error)), soft_wrap=True, highlight=False)
        raise typer.Exit(1) from None
    what = f"the secret and {len(published.sets)} sets are those" if draw else "the secret is the one"
    console.print(styled(("revealed", "bold green"), f": {what} that {published.name} commits to"), soft_wrap=True)


def _draw(file: Path) -> tuple[str, dict[str, str]]:
    from threewe.benchmark.commitments import draw_sets, read_secret
    from threewe.benchmark.sampling import SCENES

    secret = read_secret(file)
    with progress("sets of episodes", len(SCENES)) as advance:
        return secret, draw_sets(secret, lambda _: advance())
