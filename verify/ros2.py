"""Robots over a network: on ROS 2 in real time, a process on Fast DDS stands in for it; in Gazebo in lockstep, one on
Gazebo's transport does.
"""

import statistics

from threewe.testing import check_names

from verify.cases import gazebo_robots, real_links
from verify.cases.real_robots import (
    CUTS,
    PARTS,
    ROBOTS,
    cut_the_link,
    delegate,
    drive_over_a_bad_link,
    keep_the_contract,
)
from verify.harness import (
    Case,
    Experiment,
    all_of,
    each,
    ratio_of,
    share_within,
    where,
    whole_of,
    within,
    worst_of,
)

MESSAGES = sorted(path.name for path in real_links.MESSAGES.iterdir())
OTHERS_READ = (
    "test_ros2_serve.py::test_a_record_on_another_dds_is_what_the_simulator_measured",
    "test_ros2_serve.py::test_messages_of_all_types_reach_another_dds_and_come_back",
    "test_real_security.py::test_messages_of_all_types_reach_a_secured_peer_on_another_dds",
)
SCENES = ["office_v2", "apartment_v1", "warehouse_v1"]
CHECKS = check_names()
ATTACKS = 32
AT_ONCE = 6
"""Pairs of a robot and its base in real time: each takes a tenth of a core."""
INAPPLICABLE = (
    "time runs by itself",
    "more may arrive between two polls",
    "the robot has no camera",
    "no colour ahead of the robot is known",
    "the base can drive sideways",
    "the backend does not claim",
    "the world is not simulated",
)
"""Why a check may not apply to a robot on ROS 2: 32 of 93 do not with micro-ROS, 27 with a camera."""
GAZEBO_ROBOTS = ["3we_standard_v2", "3we_depth_v2", "turtlebot_like"]

AS_SIMULATED = [
    ratio_of(
        "goals reached, as a share of the simulator's own",
        lambda case: case["arrived"],
        lambda case: case["mock_arrived"],
        at_least=0.98,
    ),
    worst_of("contact speed [m/s]", lambda case: case["contact_speed"], at_most=0.05),
]


def median_jitter(cases: list[Case]) -> tuple[str, str, bool | None]:
    """Of all cases together: in one of them the computer may have been busy with something else."""
    more = statistics.median(case["more_jitter"] for case in cases)
    idle = statistics.median(case["idle_jitter"] for case in cases)
    return f"{more:.4f}, without {idle:.4f}", "<= 0.002", more <= 0.002


def total_packets(cases: list[Case]) -> tuple[str, str, bool]:
    """Of all cases together; each has as many as its time allows."""
    packets = sum(case["packets"] for case in cases)
    return f"{packets}", ">= 1000000", packets >= 1_000_000


EXPERIMENTS = [
    Experiment(
        "check_backend of robots on ROS 2",
        keep_the_contract,
        variants=[{"check": check, "robot": robot} for robot in ROBOTS for check in CHECKS],
        cases=len(ROBOTS) * len(CHECKS),
        rows=[
            all_of("no check fails", lambda case: case["outcome"] != "failed"),
            all_of(
                "what does not apply is of simulators, or of a camera that the robot has not",
                lambda case: case["outcome"] != "not_applicable" or case["detail"].startswith(INAPPLICABLE),
            ),
        ],
    ),
    Experiment(
        "check_backend of robots in Gazebo",
        gazebo_robots.keep_the_contract,
        variants=[{"check": check, "hardware": hardware} for hardware in GAZEBO_ROBOTS for check in CHECKS],
        cases=len(GAZEBO_ROBOTS) * len(CHECKS),
        rows=[all_of("no check fails", lambda case: case["outcome"] != "failed")],
    ),
    Experiment(
        "episodes in Gazebo",
        gazebo_robots.drive,
        variants=[{"scene": scene} for scene in SCENES],
        cases=50 * len(SCENES),
        rows=AS_SIMULATED,
    ),
    Experiment(
        "move_to within 6 m over a link of 20 +- 10 ms that loses 1 %",
        drive_over_a_bad_link,
        variants=[{"scene": scene} for scene in SCENES],
        cases=50 * len(SCENES),
        at_once=AT_ONCE,
        rows=[*AS_SIMULATED, *each("scene", SCENES, lambda _: AS_SIMULATED[0])],
    ),
    Experiment(
        "1 m there and back over packets that are late, lost, reordered and doubled",
        real_links.drive_over_packets,
        variants=[{"delegated": False}, {"delegated": True}],
        cases=100,
        rows=[
            all_of("it arrives there and back", lambda case: case["arrived"]),
            worst_of("contact speed [m/s]", lambda case: case["contact_speed"], at_most=0.05),
        ],
    ),
    Experiment(
        "streams of images with commands",
        real_links.carry_streams,
        cases=20,
        alone=True,
        rows=[
            worst_of(
                "a scan from the wire to the autonomy stack, median [s]",
                lambda case: case["scan_latency"],
                at_most=0.001,
            ),
            worst_of("the same with images [s]", lambda case: case["scan_latency_beside_images"], at_most=0.001),
            where(
                all_of("no image is lost with a receive buffer of 4 MiB", lambda case: case["lost"] == 0),
                lambda case: case["granted"] >= 4 << 20,
            ),
            all_of(
                "with one of 208 KiB, what is lost is named",
                lambda case: case["lost_of_small"] == 0 or "lost" in case["said_of_small"],
            ),
            whole_of("jitter of commands above that without images, p99 [s]", median_jitter),
        ],
    ),
    Experiment(
        "goals that are delegated to Nav2",
        delegate,
        variants=[{"part": part} for part in range(PARTS)],
        cases=PARTS,
        rows=[
            share_within(
                "every outcome, cancel and failure code arrives",
                lambda case: case["goals"],
                lambda goal: goal["reason"] == goal["expected"],
                at_least=1.0,
            ),
            all_of("every cancel is received", lambda case: case["cancelled"] == case["to_cancel"]),
        ],
    ),
    Experiment(
        "the link is cut while it drives",
        cut_the_link,
        cases=1000 // CUTS,
        at_once=AT_ONCE,
        rows=[
            within(
                worst_of("the base is commanded to move after a cut for [s]", lambda c: c["moving_for"], at_most=0.22),
                lambda case: case["cuts"],
            ),
            within(
                worst_of("the base itself moves for, as it brakes [s]", lambda c: c["rolling_for"], at_most=0.35),
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
    Experiment(
        "changed payloads of each type",
        real_links.read_payloads,
        {"inputs": 1_000_000},
        variants=[{"message": message} for message in MESSAGES],
        cases=len(MESSAGES),
        rows=[all_of("a million without a crash, or memory above 16 times their size", lambda case: case["ok"])],
        limit=3600.0,
        by_night=False,
    ),
    Experiment(
        "changed packets of RTPS, with those of the robot",
        real_links.attack,
        {"seconds": 20.0},
        cases=ATTACKS,
        at_once=1,
        rows=[
            all_of("our process goes on, and ends when it is asked to", lambda case: case["ended"] == 0),
            worst_of("memory that it grows by [MiB]", lambda case: case["grown"], at_most=64.0),
            all_of("the base stands in the end", lambda case: case["speed"] < 0.01),
            worst_of("contact speed [m/s]", lambda case: case["contact_speed"], at_most=0.05),
            whole_of("packets in all, to a process without sanitizers", total_packets),
        ],
    ),
    Experiment(
        "what others read",
        real_links.run_test,
        variants=[{"test": test} for test in OTHERS_READ],
        cases=30,
        rows=[
            all_of(
                "records of a served robot, and messages of all types there and back, secured and not",
                lambda case: case["ok"],
            )
        ],
    ),
]
