"""Recordings that survive: kills, power cuts, failing disks, hostile datasets; and what recording costs."""

from verify.cases.hostile_datasets import cases as hostile_cases
from verify.cases.hostile_datasets import meet
from verify.cases.recording import in_real_time, killed, trials
from verify.harness import Case, Experiment, all_of, worst_of

KILLS = 100  # of a case
DISKS = 20  # that a power cut after one call may leave
PARTS = 20  # of the allocations, by turns


def kills(seed: int) -> Case:
    """Forked C++ recorders, killed at random times and before, in and after their calls of the operating system."""
    return trials("kills", seed % 2**31 * KILLS, KILLS)


def power_cuts(seed: int) -> Case:
    """Every prefix of what a disk was told; what was not synced is there, torn, zeroed or lost."""
    return trials("power", seed % 2**31, DISKS)


def failing_disk(_seed: int) -> Case:
    """Each call of the operating system fails once: disk full, input/output error, short write."""
    return trials("faults")


def failing_allocations(_seed: int, part: int) -> Case:
    """Each allocation of the recorder fails once: by turns, so that few cases try some of all."""
    return trials("allocations", part, PARTS)


def hostile(seed: int) -> Case:
    """Two hundred spoiled LeRobot datasets, read as a whole."""
    met = [meet(name, attack, seed) for name, attack in hostile_cases(seed)]
    wrong = [one["name"] for one in met if one["refused"] is None or not one["untouched"] or one["leaked"]]
    return {"wrong": wrong, "trials": len(met)}


def nothing_wrong(case: Case) -> bool:
    return case["trials"] > 0 and not case["wrong"]


EXPERIMENTS = [
    Experiment(
        f"{KILLS} kills of the C++ recorder a case",
        kills,
        cases=100,
        rows=[all_of("no finished episode lost, at most a second of the current", nothing_wrong)],
    ),
    Experiment(
        "kills of the Python recorder with video and depth",
        killed,
        cases=300,
        rows=[
            all_of("no finished episode lost", lambda case: case["finished_lost"] <= 0),
            worst_of("ticks of the current lost", lambda case: case["ticks_lost"], at_most=50),
        ],
    ),
    Experiment(
        f"power cuts after every call, {DISKS} disks each",
        power_cuts,
        cases=20,
        rows=[all_of("recovered, and all that was promised there", nothing_wrong)],
    ),
    Experiment(
        "each call of the disk fails once",
        failing_disk,
        cases=1,
        rows=[all_of("a clear error, finished episodes readable", nothing_wrong)],
    ),
    Experiment(
        "each allocation of the recorder fails once",
        failing_allocations,
        variants=[{"part": part} for part in range(PARTS)],
        cases=PARTS,
        rows=[all_of("an error, finished episodes readable", nothing_wrong)],
    ),
    Experiment(
        "200 hostile LeRobot datasets a case",
        hostile,
        cases=5,
        rows=[all_of("refused, nothing outside read or written", nothing_wrong)],
    ),
    Experiment(
        "a minute in real time on one core: 50 Hz state, 30 Hz 640x480 colour, 10 Hz lidar",
        in_real_time,
        {"seconds": 60.0},
        cases=3,
        alone=True,
        rows=[
            worst_of("ticks dropped", lambda case: case["dropped"], at_most=0),
            worst_of("images missing, of 1800", lambda case: case["frames_missing"], at_most=3),
            worst_of("share of the core, the simulator's included", lambda case: case["load"], at_most=0.6),
            worst_of("[s] of thread CPU time added to a tick's 99th percentile", lambda c: c["added"], at_most=1e-3),
            worst_of("[s] for end_episode", lambda case: case["end_episode"], at_most=0.3),
            worst_of("[MiB] of memory", lambda case: case["memory"], at_most=300.0),
        ],
    ),
]
