"""How the autonomy stack answers to half and twice of each of its parameters, in places that nothing was tuned on."""

from verify.cases.sensitivity import sensitivity, write_page
from verify.harness import Case, Experiment, all_of, info


def changes(cases: list[Case]) -> str:
    names = [name for name, answer in cases[0]["answers"].items() if answer]
    alike = [name for name in names if all(case["answers"][name]["same"] for case in cases)]
    return f"{len(names)} changes, of which {len(alike)} change no drive"


def tells_the_truth(case: Case) -> bool:
    """No change makes the robot say `reached` where it is not."""
    return not any(answer and answer["untrue"] for answer in case["answers"].values())


EXPERIMENTS = [
    Experiment(
        "half and twice of each parameter",
        sensitivity,
        cases=8,
        rows=[
            info("changes", changes),
            all_of("whatever is changed, reached is said only within 0.25 m", tells_the_truth),
        ],
        limit=7200.0,
        by_night=False,
        learn=write_page,
    )
]
