"""python -m verify [area ...] [options]: runs areas, lists them, or makes the page of claims (`claims`)."""

import argparse
import importlib
import math
import os
import sys
import time
from collections import Counter
from pathlib import Path

from verify.harness import claims
from verify.harness.area import Options, verify
from verify.harness.journal import Revision

HERE = Path(__file__).parent
AREAS = sorted(path.stem for path in HERE.glob("*.py") if path.stem not in ("__init__", "__main__"))
STATUSES = {"pass": "passed", "FAIL": "failed", "known miss": "known misses", "info": "info", "not shown": "not shown"}


def main() -> int:
    """Runs what was asked for; 1 if a claim failed."""
    os.environ.pop("THREEWE_MODEL", None)  # claims are about instructions without a model where they name none
    options = parse()
    areas = {name: area(name) for name in AREAS}
    if options.areas == ["claims"]:
        claims.PAGE.write_text(claims.page(areas))
        return 0
    if not options.areas and not options.sample:
        for name, one in areas.items():
            print(f"{name:16}{one.title}")
        return 0

    how = {name: value for name, value in vars(options).items() if name not in ("areas", "seconds")}
    how["deadline"] = time.monotonic() + options.seconds
    first = Revision.here().seed % len(AREAS)  # so that each is run now and then where there is no time for all
    names = options.areas or AREAS[first:] + AREAS[:first]
    outcomes = {name: verify(name, areas[name].experiments, Options(**how)) for name in names}
    if options.write:
        claims.PAGE.write_text(claims.page(areas))
    total = sum((outcome.statuses for outcome in outcomes.values()), Counter())
    print("\ntook " + ", ".join(f"{area} {outcome.seconds:.0f} s" for area, outcome in outcomes.items()))
    print("verify: " + ", ".join(f"{total[status]} {word}" for status, word in STATUSES.items()))
    return int(total["FAIL"] > 0)


def area(name: str) -> claims.Area:
    """What one of the files beside this one runs."""
    module = importlib.import_module(f"verify.{name}")
    return claims.Area((module.__doc__ or "").splitlines()[0], module.EXPERIMENTS)


def parse() -> argparse.Namespace:
    """The options, which go together."""
    parser = argparse.ArgumentParser(prog="./dev verify", description="Runs the full counts behind published claims.")
    parser.add_argument("areas", nargs="*", metavar="area", help=f"{', '.join(AREAS)}; or claims: makes their page")
    parser.add_argument("--sample", action="store_true", help="a few cases of each experiment, tested with the record")
    parser.add_argument("--count", type=int, help="so many cases of each experiment")
    parser.add_argument("--seconds", type=float, default=math.inf, help="begin no experiment after so long")
    parser.add_argument("--seed", type=int, help="draws the cases; by default from the commit")
    parser.add_argument("--only", default="", metavar="TEXT", help="experiments with this text in their names")
    parser.add_argument("--record", action="store_true", help="with --sample: add what was seen to verify/record.jsonl")
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
    if options.record and not options.sample:
        parser.error("--record keeps samples: it goes with --sample")
    if options.write and (options.sample or options.count):
        parser.error("--write publishes full runs: it goes without --sample and --count")
    return options


if __name__ == "__main__":
    sys.exit(main())
