"""python -m verify [area ...] [--sample] [--count N] [--seed N] [--write-model] [--write PAGE]: runs or lists areas."""

import argparse
import importlib
import sys
from pathlib import Path

from verify.harness import verify

HERE = Path(__file__).parent
AREAS = sorted(path.stem for path in HERE.glob("*.py") if path.stem not in ("__init__", "__main__", "harness"))


def main() -> int:
    """Runs what was asked for; 1 if a claim failed."""
    parser = argparse.ArgumentParser(prog="./dev verify", description="Runs the full counts behind published claims.")
    parser.add_argument("areas", nargs="*", metavar="area", help=", ".join(AREAS))
    parser.add_argument("--sample", action="store_true", help="a few cases of each experiment")
    parser.add_argument("--count", type=int, help="so many cases of each experiment")
    parser.add_argument("--seed", type=int, help="draws the cases; by default from the commit")
    parser.add_argument("--write-model", action="store_true", help="slam: write the localisation model measured")
    parser.add_argument("--write", type=Path, metavar="PAGE.md", help="put the rows into a page, between its two marks")
    options = parser.parse_args()
    if options.write and len(options.areas) != 1:
        parser.error("--write takes the rows of one area")
    if unknown := set(options.areas) - set(AREAS):
        parser.error(f"no area {', '.join(unknown)}; there are {', '.join(AREAS)}")
    if not options.areas and not options.sample:
        for area in AREAS:
            print(f"{area:16}{(importlib.import_module(f'verify.{area}').__doc__ or '').splitlines()[0]}")
        return 0

    statuses = []
    for area in options.areas or AREAS:
        experiments = importlib.import_module(f"verify.{area}").EXPERIMENTS
        statuses += verify(
            area,
            experiments,
            seed=options.seed,
            count=options.count,
            sample=options.sample,
            write_model=options.write_model,
            page=options.write,
        )
    passed, failed, told, hidden = (statuses.count(status) for status in ("pass", "FAIL", "told", "not shown"))
    others = "".join(f", {count} {what}" for count, what in [(told, "told"), (hidden, "skipped")] if count)
    print(f"\nverify: {passed} passed, {failed} failed{others}")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
