"""Checks of a backend against the contract, ours or a third party's; and a scripted server of models."""

from __future__ import annotations

import re
from collections.abc import Sequence

from rich.progress import track
from rich.table import Table

from threewe import _core
from threewe._arguments import as_list, as_seed, as_text
from threewe._console import plain_console, styled
from threewe._core import CheckResult, Outcome, check_names
from threewe._model_server import ModelServer
from threewe.backend import known_backend
from threewe.errors import ConfigError, ContractError

__all__ = ["CheckResult", "ModelServer", "Outcome", "check_backend", "check_names"]

COLORS = {Outcome.passed: "green", Outcome.failed: "bold red", Outcome.not_applicable: "dim"}


def check_backend(
    backend: str,
    *,
    hardware: str = "3we_standard_v2",
    scene: str = "office_v2",
    noise: str = "realistic",
    seed: int = 0,
    color_ahead: str = "",
    checks: Sequence[str] | None = None,
    show: bool = True,
    raise_failures: bool = False,
) -> list[CheckResult]:
    """Runs the contract's checks against a backend, each on a fresh world, and shows a table.

    The checks drive the robot: it needs 1.5 m of free floor ahead, 0.6 m to the left, and a person who watches it when
    it is a real one. A check of something that the backend does not claim is `not_applicable`.

    Args:
        backend: its name.
        hardware: as for Robot.
        scene: as for Robot.
        noise: as for Robot.
        seed: as for Robot.
        color_ahead: `red` or `blue`, where such a thing fills the middle of the camera's image at the start. Without
            one, the order of colours is checked only of simulators that paint scenes as ours do.
        checks: some of `check_names()`; all of them where None.
        show: print progress and the table.
        raise_failures: raise ContractError with all failures, where there are any.

    Raises:
        ConfigError: an unknown backend or check, with the nearest right name.
    """
    names = check_names() if checks is None else [as_text("checks", name) for name in as_list("checks", checks)]
    if known_backend(as_text("backend", backend)) not in _core.backend_names():
        raise ConfigError(_core.unknown_name("backend", backend, _core.backend_names()))
    results = [
        _core.run_check(
            name,
            backend=backend,
            scene=as_text("scene", scene),
            hardware=as_text("hardware", hardware),
            noise=as_text("noise", noise),
            seed=as_seed("seed", seed),
            color_ahead=as_text("color_ahead", color_ahead),
        )
        for name in track(names, "checking", disable=not show, transient=True)
    ]
    failures = _group([result for result in results if not result.passed])
    if show:
        console = plain_console()
        console.print(_table(backend, results, failures))
        for group in failures:  # a table's column is too narrow for what must be read to the end
            console.print(styled((group[0].name, COLORS[Outcome.failed])), f": {_summary(group)}", sep="")
    if failures and raise_failures:
        count = sum(len(group) for group in failures)
        failed = "".join(f"\n  {group[0].name}: {_summary(group)}" for group in failures)
        raise ContractError(f"backend '{backend}' fails {count} of {len(results)} checks:{failed}")
    return results


def _group(failures: Sequence[CheckResult]) -> list[list[CheckResult]]:
    """Failures of one cause together: those whose details differ in nothing but numbers."""
    groups: dict[str, list[CheckResult]] = {}
    for failure in failures:
        groups.setdefault(re.sub(r"-?\d+(\.\d+)?(e[+-]?\d+)?", "#", failure.detail), []).append(failure)
    return list(groups.values())


def _summary(group: Sequence[CheckResult]) -> str:
    """What a group of failures has in common, once."""
    others = len(group) - 1
    more = f" (the same at {others} more check{'s' if others > 1 else ''})" if others else ""
    return group[0].detail + more


def _table(backend: str, results: Sequence[CheckResult], failures: Sequence[Sequence[CheckResult]]) -> Table:
    table = Table(title=f"backend '{backend}'")
    table.add_column("check", no_wrap=True)
    table.add_column("outcome", no_wrap=True)
    table.add_column("detail")
    details = {result.name: result.detail for result in results}
    for first, *others in failures:
        details[first.name] = "see below"
        details.update({other.name: f"as {first.name}" for other in others})
    for result in results:
        outcome = result.outcome.name.replace("_", " ")
        table.add_row(result.name, styled((outcome, COLORS[result.outcome])), details[result.name])
    return table
