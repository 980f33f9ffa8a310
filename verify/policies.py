"""Learned policies: hostile folders are refused, faults stop the robot, runs in lockstep repeat."""

from verify.cases.policies import fail, repeat, spoil
from verify.harness import Experiment, all_of

EXPERIMENTS = [
    Experiment(
        "hostile folders of policies",
        spoil,
        cases=300,
        sample=30,
        rows=[
            all_of("refused with file and reason", lambda case: case["refused"]),
            all_of("nothing is written", lambda case: case["untouched"]),
        ],
    ),
    Experiment(
        "faults of a policy at drawn moments",
        fail,
        cases=1000,
        sample=12,
        rows=[
            all_of("the fault is named", lambda case: case["named"]),
            all_of("the robot is commanded to stand within 0.25 s", lambda case: case["stood"]),
            all_of("the robot is usable at once", lambda case: case["usable"]),
        ],
    ),
    Experiment(
        "a policy driven twice in lockstep",
        repeat,
        cases=40,
        sample=4,
        rows=[all_of("the same commands to the bit", lambda case: case["same"])],
    ),
]
