"""Steps of other simulators, with the scene, beams, period and steps of physics of ours, timed in the same run.

Enki drives a round robot on two wheels among the same outlines in 2D. MuJoCo does different work: bodies, contacts and
rays in 3D; of its two robots the faster counts. Neither has noise, a gate, rewards or episodes, which ours has: a ratio
is that of what a user waits for.
"""

from __future__ import annotations

import statistics
from collections import defaultdict
from collections.abc import Sequence

from env_steps import Kind
from peers_bench import PEERS as KNOWN
from peers_bench import PLACE, installed, time_peer
from peers_given import describe_office

PEERS = ("Enki", "MuJoCo")
PHYSICS_PER_TICK = 2  # steps


def time_peers(kinds: Sequence[Kind]) -> tuple[dict[tuple[int, int], dict[str, float]], list[str]]:
    """Seconds of a step by beams and ticks, and by peer; and a line for each peer that has none."""
    found: dict[tuple[int, int], dict[str, float]] = defaultdict(dict)
    present = [name for name in PEERS if installed(KNOWN[name])]
    remarks = [f"no ratio to {name}, which is not installed: {KNOWN[name].install}" for name in PEERS]
    remarks = [remark for name, remark in zip(PEERS, remarks, strict=True) if name not in present]
    if not present:
        return found, remarks

    PLACE.mkdir(parents=True, exist_ok=True)
    office = describe_office()
    for ticks in sorted({kind.ticks for kind in kinds}):
        office.substeps = PHYSICS_PER_TICK * ticks
        world = f"ticks_{ticks}.txt"
        office.write(PLACE / world)
        for name in present:
            results, failure = time_peer(name, world, "step")
            remarks += [failure] if failure else []
            for result in results:
                theirs = found[int(result["size"]), ticks]
                theirs[name] = min(theirs.get(name, float("inf")), statistics.median(result["seconds"]))
    return found, remarks
