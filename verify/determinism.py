"""Robots among people, and learning environments: the same bits on every vector target and processor."""

from verify.cases.end_to_end_hash import processors, targets
from verify.harness import Case, Experiment, Row, all_of, info


def was_run(target: str, name: str) -> Row:
    """In how many cases the machine had that target, so that the claim above includes it."""
    return info(
        f"{name} was among them", lambda cases: f"{sum(target in case['targets'] for case in cases)}/{len(cases)} cases"
    )


def several_targets(case: Case) -> bool:
    """One target is equal to itself: that shows nothing."""
    return case["equal"] and len(case["targets"]) >= 2


RUNS = {
    "verify_end_to_end_hash": "three robots among people: world, autonomy stacks and gates, fresh and restored",
    "verify_episodes": "learning environments: every task, ten seconds",
}
EXPERIMENTS = [
    *(
        Experiment(
            name,
            targets,
            {"program": program},
            cases=100,
            rows=[
                all_of("same bits on every target", several_targets),
                was_run("AVX3", "AVX-512"),
                was_run("AVX2", "AVX2"),
                was_run("SCALAR", "scalar code"),
            ],
        )
        for program, name in RUNS.items()
    ),
    *(
        Experiment(
            f"aarch64, emulated: {name.partition(':')[0]}",
            processors,
            {"program": program},
            cases=20,
            rows=[all_of("same bits as on this processor", lambda case: case["equal"])],
        )
        for program, name in RUNS.items()
    ),
]
