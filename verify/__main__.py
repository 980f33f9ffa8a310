"""python -m verify [area ...] [options]: runs areas, lists them, or makes the page of claims (`claims`)."""

import argparse
import importlib
import math
import os
import random
import sys
import time
from datetime import UTC, datetime
from pathlib import Path

from verify.harness import Experiment, claims
from verify.harness.area import Options, verify
from verify.harness.journal import Revision

HERE = Path(__file__).parent
AREAS = sorted(path.stem for path in HERE.glob("*.py") if path.stem not in ("__init__", "__main__"))
OTHERS = {"known miss": "known misses", "info": "info", "not shown": "not shown"}


def main() -> int:
    """Runs what was asked for; 1 if a claim failed."""
    os.environ.pop("THREEWE_MODEL", None)  # claims are about instructions without a model where they name none
    options = parse()
    areas = {name: area(name) for name in AREAS}
    if options.areas == ["claims"]:
        claims.PAGE.write_text(claims.page(areas))
        return 0
    if not options.areas and not options.drawn:
        for name, one in areas.items():
            print(f"{name:16}{one.title}")
        return 0

    seed, deadline = options.seed, time.monotonic() + options.seconds
    experiments = [(name, one) for name in options.areas or AREAS for one in areas[name].experiments]
    experiments = [(name, one) for name, one in experiments if options.only in one.name]
    if options.drawn:
        seed = Revision.here().seed_of(datetime.now(UTC).date()) if seed is None else seed
        experiments = drawn(experiments, seed)
    total = verify(experiments, Options(seed, options.count, deadline, options.write, options.write_model))
    if options.write:
        claims.PAGE.write_text(claims.page(areas))
    print("\n" + ", ".join(f"{total[status]} {word}" for status, word in OTHERS.items()))
    print(f"verify: {total['pass']} passed, {total['FAIL']} failed")
    return int(total["FAIL"] > 0)


def drawn(experiments: list[tuple[str, Experiment]], seed: int) -> list[tuple[str, Experiment]]:
    """Those that a night is enough for, in an order that follows from the seed."""
    short = [(name, one) for name, one in experiments if one.by_night]
    return random.Random(seed).sample(short, len(short))


def area(name: str) -> claims.Area:
    """What one of the files beside this one runs."""
    module = importlib.import_module(f"verify.{name}")
    return claims.Area((module.__doc__ or "").splitlines()[0], module.EXPERIMENTS)


def parse() -> argparse.Namespace:
    """The options, which go together."""
    parser = argparse.ArgumentParser(prog="./dev verify", description="Runs the full counts behind published claims.")
    parser.add_argument("areas", nargs="*", metavar="area", help=f"{', '.join(AREAS)}; or claims: makes their page")
    parser.add_argument("--drawn", action="store_true", help="experiments of all areas, or those named, in drawn order")
    parser.add_argument("--count", type=int, help="so many cases of each experiment")
    parser.add_argument("--seconds", type=float, default=math.inf, help="begin no case after so long")
    parser.add_argument("--seed", type=int, help="draws the cases; by default from the commit, drawn also from the day")
    parser.add_argument("--only", default="", metavar="TEXT", help="experiments with this text in their names")
    parser.add_argument(
        "--write",
        action="store_true",
        help="write full runs, experiment by experiment, into verify/results and docs/claims.md",
    )
    parser.add_argument("--write-model", action="store_true", help="slam: write the localisation model measured")
    options = parser.parse_args()
    if unknown := set(options.areas) - {*AREAS, "claims"}:
        parser.error(f"no area {', '.join(unknown)}; there are {', '.join(AREAS)}")
    if "claims" in options.areas and len(options.areas) > 1:
        parser.error("claims makes a page: it goes with no area")
    if options.write and options.count:
        parser.error("--write publishes full runs: it goes without --count")
    return options


if __name__ == "__main__":
    sys.exit(main())
