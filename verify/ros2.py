"""A robot on ROS 2, reached over DDS: a process on Fast DDS stands in for it. All of it is in real time."""

from threewe.testing import check_names

from verify.cases.real_robots import cut_the_link, drive_over_a_bad_link, keep_the_contract
from verify.harness import Experiment, all_of, ratio_of, share_within, within, worst_of

SCENES = ["office_v2", "apartment_v1", "warehouse_v1"]
CHECKS = check_names()

EXPERIMENTS = [
    Experiment(
        "check_backend of a robot with micro-ROS",
        keep_the_contract,
        variants=[{"check": check} for check in CHECKS],
        cases=len(CHECKS),
        sample=1,
        rows=[all_of("no check fails", lambda case: case["outcome"] != "failed")],
    ),
    Experiment(
        "near goals over a link of 20 +- 10 ms that loses 1 %",
        drive_over_a_bad_link,
        variants=[{"scene": scene} for scene in SCENES],
        cases=50 * len(SCENES),
        sample=1,
        rows=[
            ratio_of(
                "goals reached, as a share of the simulator's own",
                lambda case: case["arrived"],
                lambda case: case["mock_arrived"],
                at_least=0.98,
            ),
            worst_of("contact speed [m/s]", lambda case: case["contact_speed"], at_most=0.05),
        ],
    ),
    Experiment(
        "the link is cut while it drives",
        cut_the_link,
        cases=500,
        sample=1,
        rows=[
            within(
                worst_of("the base is commanded to move after a cut for [s]", lambda c: c["moving_for"], at_most=0.22),
                lambda case: case["cuts"],
            ),
            within(
                worst_of("our side says so after [s]", lambda cut: cut["noticed"], at_most=0.3),
                lambda case: case["cuts"],
            ),
            share_within(
                "it stands once the link is mended", lambda case: case["cuts"], lambda c: not c["started"], at_least=1.0
            ),
        ],
    ),
]
