"""python -m verify.pairs [set ...] [options]: drives the fixed episodes and compares them with `verify/baseline`."""

from __future__ import annotations

import argparse
import os
import sys
import time

from threewe import available_targets
from threewe.benchmark.runner import Finished, Job, run_jobs

from verify.pairs import baseline
from verify.pairs.comparison import differences, summary
from verify.pairs.drives import SETS, Drive
from verify.pairs.outcomes import Outcome, perform
from verify.pairs.policies import of_policy

LIMIT = 600.0  # [s] of wall time for a drive
SHOWN = 40  # drives that differ are printed, of each set


def main() -> int:
    """Compares, or renews; 1 if a drive differs, 2 if there is nothing to compare with."""
    options = parse()
    listed = {name: [one for one in SETS[name]() if options.only in one.name] for name in options.sets or SETS}
    try:
        before = {name: on_file(name, drives) for name, drives in listed.items()} if not options.renew else {}
        now = {name: drive_all(name, drives, options) for name, drives in listed.items() if drives}
    except baseline.BaselineError as error:
        print(error, file=sys.stderr)
        return 2
    return renew(now) if options.renew else compare(before, now)


def on_file(name: str, drives: list[Drive]) -> dict[str, Outcome]:
    """Returns the outcomes on file of these drives. Raises BaselineError for a file that is not of this set."""
    known = baseline.read(name, [one.name for one in SETS[name]()])
    return {one.name: known[one.name] for one in drives}


def drive_all(name: str, drives: list[Drive], options: argparse.Namespace) -> dict[str, Outcome]:
    """Drives a set, two at a time; a drive that raises or dies is an outcome too."""
    jobs = []
    for one in drives:
        arguments = one.arguments | ({"renew": True} if options.renew and one.function is of_policy else {})
        arguments = {"function": one.function, "arguments": arguments, "target": options.target}
        jobs.append(Job(one.name, perform, arguments, LIMIT))
    begun = time.monotonic()
    found = run_jobs(jobs, options.workers, on_done=show_failure)
    seconds = time.monotonic() - begun
    print(f"{name:14} {len(jobs):4} drives {seconds:6.0f} s", flush=True)
    return {job.key: one.result or broken(one) for job, one in zip(jobs, found, strict=True)}


def broken(finished: Finished) -> Outcome:
    """Returns the outcome of a drive that came to none."""
    line = finished.failure.strip().splitlines()[-1]
    return {"reason": f"broke: {line}"[:200], "success": False, "seconds": 0.0, "metres": 0.0, "hash": ""}


def show_failure(job: Job, finished: Finished) -> None:
    """Prints at once why a drive came to nothing."""
    if finished.failure:
        print(f"{job.key}: {finished.failure}", file=sys.stderr, flush=True)


def compare(before: dict[str, dict[str, Outcome]], now: dict[str, dict[str, Outcome]]) -> int:
    """Prints the drives that differ, and what they come to."""
    count = differing = 0
    for name, outcomes in now.items():
        found = differences(before[name], outcomes)
        count, differing = count + len(outcomes), differing + len(found)
        if found:
            print(f"\n{name}: {len(found)} of {len(outcomes)} drives differ")
            print(*(f"  {one}" for one in found[:SHOWN]), sep="\n")
            print(*(f"  {line}" for line in summary(before[name], outcomes)), sep="\n")
    if differing:
        print("\nA change that means to differ renews the baseline, and its diff is reviewed: ./dev pairs --renew")
    else:
        print("\nproved unchanged: each drive is the one on file to the bit")
    print(f"pairs: {count - differing} passed, {differing} failed")
    return int(differing > 0)


def renew(now: dict[str, dict[str, Outcome]]) -> int:
    """Puts the outcomes on file, and prints the drives that differ from those before."""
    for name, outcomes in now.items():
        try:
            before = baseline.read(name)
        except baseline.BaselineError as error:
            print(f"nothing to compare with: {error}")
        else:
            both = {drive: one for drive, one in outcomes.items() if drive in before}
            found = differences(before, both)
            new = len(outcomes) - len(both)
            print(f"\n{name}: {len(found)} of {len(both)} drives differ from those before; {new} are new")
            print(*(f"  {one}" for one in [*found[:SHOWN], *summary(before, both)] if found), sep="\n")
        baseline.write(name, outcomes)
    broke = [drive for outcomes in now.values() for drive, one in outcomes.items() if not one["hash"]]
    print(*(f"{drive} broke" for drive in broke), sep="\n")
    return int(bool(broke))


def parse() -> argparse.Namespace:
    """Returns the options."""
    parser = argparse.ArgumentParser(prog="./dev pairs", description="Compares fixed drives with those on file.")
    parser.add_argument("sets", nargs="*", metavar="set", help=f"{', '.join(SETS)}; all where left out")
    parser.add_argument("--only", default="", metavar="TEXT", help="drives with this text in their names")
    parser.add_argument("--renew", action="store_true", help="put the outcomes of all drives of the sets on file")
    parser.add_argument("--target", default="", help=f"drive on one vector target: {', '.join(available_targets())}")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="processes at a time")
    options = parser.parse_args()
    if unknown := set(options.sets) - set(SETS):
        parser.error(f"no set {', '.join(sorted(unknown))}; there are {', '.join(SETS)}")
    if options.target and options.target not in available_targets():
        parser.error(f"no target {options.target} on this machine; there are {', '.join(available_targets())}")
    if options.renew and (options.only or options.target):
        parser.error("--renew puts whole sets on file: it goes without --only and --target")
    return options


if __name__ == "__main__":
    sys.exit(main())
