"""Drives to sampled goals in places that the robot has never seen; explores; listens to no simulator's lies."""

from verify.cases.doorways import through_a_doorway
from verify.cases.driving import (
    arrived,
    drive,
    drive_in_vain,
    drives_in_a_map,
    explore,
    explore_together,
    tells_the_truth,
    truly_there,
)
from verify.cases.generated import (
    arrivals,
    arrived_share,
    ends_standing,
    far_drives,
    no_clock,
    no_false_arrival,
    worst_contact,
)
from verify.cases.journey import lies
from verify.cases.people import among_people, ratio
from verify.cases.walls import away_from_a_wall, comes_to_its_goal, out_of_a_slot, touches_gently
from verify.harness import Experiment, all_of, mean_of, mean_of_all, ratio_of, share_of, told, worst_of

ROBOTS = [  # where, who, and how often it arrives at least
    ("office_v2", "3we_standard_v2", 0.99),
    ("corridor_v1", "3we_standard_v2", 0.99),
    ("apartment_v1", "3we_standard_v2", 0.99),
    ("warehouse_v1", "3we_standard_v2", 0.99),
    ("cluttered_v1", "3we_standard_v2", 0.99),
    ("outdoor_v1", "3we_standard_v2", 0.99),
    ("dynamic_v1", "3we_standard_v2", 0.97),
    ("office_v2", "turtlebot_like", 0.97),
]

ARRIVED = "reached, truly within 0.25 m"

FAR_DRIVES = [  # where, who, in how many places, how many drives in each, and how many of them arrive at least
    ("building", "3we_standard_v2", 100, 8, 0.95),
    ("building", "turtlebot_like", 50, 4, 0.85),
    ("hall", "turtlebot_like", 40, 2, None),
    ("hall", "3we_standard_v2", 40, 2, None),
    ("corridor", "turtlebot_like", 40, 2, None),
    ("corridor", "3we_standard_v2", 40, 2, None),
]

EXPERIMENTS = [
    *(
        Experiment(
            f"far goals, {hardware} in a generated {place}",
            far_drives,
            {"place": place, "hardware": hardware, "drives": drives},
            cases=places,
            sample=3,
            rows=[
                all_of("no drive ends by a clock", no_clock),
                all_of("no false arrival", no_false_arrival),
                all_of("arrives standing", ends_standing),
                worst_of("contact by its own motion [m/s]", worst_contact, at_most=0.05),
                mean_of_all(ARRIVED, arrivals, at_least=enough) if enough else told(ARRIVED, arrived_share),
            ],
            limit=3600.0,
        )
        for place, hardware, places, drives, enough in FAR_DRIVES
    ),
    *(
        Experiment(
            f"move_to, {hardware} in {scene}",
            drive,
            {"scene": scene, "hardware": hardware},
            cases=200,
            sample=8,
            rows=[
                share_of("reached, truly within 0.25 m", arrived, at_least=enough),
                ratio_of(
                    "SPL, as a share of the optimist's",
                    lambda case: case["spl"],
                    lambda case: case["optimist_spl"],
                    at_least=0.95,
                ),
                worst_of("contact by its own motion [m/s]", lambda case: case["contact_speed"], at_most=0.05),
            ],
        )
        for scene, hardware, enough in ROBOTS
    ),
    *(
        Experiment(
            f"move_to in a given map, {hardware} in {scene}",
            drives_in_a_map,
            {"scene": scene, "drives": 10},
            cases=20,
            sample=1 if scene == "office_v2" else 0,
            rows=[
                mean_of("reached, truly within 0.25 m", lambda case: case["arrived"], at_least=enough),
                mean_of_all("SPL", lambda case: case["spl"], at_least=0.93),
                worst_of("contact by its own motion [m/s]", lambda case: case["contact_speed"], at_most=0.05),
            ],
        )
        for scene, hardware, enough in ROBOTS
        if hardware == "3we_standard_v2"
    ),
    *(
        Experiment(
            f"move_to where nobody can, {hardware} in {scene}",
            drive_in_vain,
            {"scene": scene, "hardware": hardware},
            cases=40,
            sample=1,
            rows=[
                share_of("no_path", lambda case: case["reason"] == "no_path", at_least=0.95),
                # it may creep where grids of 5 cm see no way
                all_of("never reached, unless it truly is there", tells_the_truth),
                worst_of("contact by its own motion [m/s]", lambda case: case["contact_speed"], at_most=0.05),
            ],
        )
        for scene, hardware, _ in ROBOTS[:2]
    ),
    *(
        Experiment(
            f"a doorway {1000 * spare:.0f} mm wider than the robot, {hardware}",
            through_a_doorway,
            {"hardware": hardware, "spare": spare},
            cases=200,
            sample=sample,
            rows=[
                share_of("reached, truly within 0.25 m", arrived, at_least=enough),
                worst_of("contact by its own motion [m/s]", lambda case: case["contact_speed"], at_most=0.05),
            ],
        )
        for hardware, spare, enough, sample in [
            ("3we_standard_v2", 0.05, 0.97, 8),
            ("3we_standard_v2", 0.1, 0.97, 4),
            ("turtlebot_like", 0.07, 0.9, 4),
        ]
    ),
    *(
        Experiment(
            f"a doorway 10 mm narrower than the robot, {hardware}",
            through_a_doorway,
            {"hardware": hardware, "spare": -0.01},
            cases=100,
            sample=2,
            rows=[
                share_of("no_path", lambda case: case["reason"] == "no_path", at_least=0.95),
                all_of("never reached", lambda case: case["reason"] != "reached"),
                worst_of("contact by its own motion [m/s]", lambda case: case["contact_speed"], at_most=0.05),
            ],
        )
        for hardware in ("3we_standard_v2", "turtlebot_like")
    ),
    *(
        Experiment(
            f"beside a wall, {hardware}",
            away_from_a_wall,
            {"hardware": hardware},
            cases=1000,
            sample=8,
            rows=[
                share_of("gets away and reaches a goal, truly within 0.25 m", arrived, at_least=0.99),
                # four cones and no lidar: what is beside a corner that turns is not always heard
                share_of("touches nothing faster than 0.05 m/s", touches_gently, at_least=gently),
            ],
        )
        for hardware, gently in [
            ("3we_standard_v2", 1.0),
            ("3we_depth_v2", 1.0),
            ("turtlebot_like", 1.0),
            ("3we_base_v2", 0.99),
        ]
    ),
    *(
        Experiment(
            f"at the end of a slot, {hardware}",
            out_of_a_slot,
            {"hardware": hardware},
            cases=200,
            sample=4,
            rows=[
                share_of("gets out and comes to its goal, truly within 0.25 m", comes_to_its_goal, at_least=0.95),
                share_of("touches nothing faster than 0.05 m/s", touches_gently, at_least=1.0),
            ],
        )
        for hardware in ("3we_standard_v2", "turtlebot_like")
    ),
    Experiment(
        "move_to by echoes, 3we_base_v2 in office_v2",
        drive,
        {"scene": "office_v2", "hardware": "3we_base_v2"},
        cases=200,
        sample=8,
        rows=[
            # most drives end as `uncertain`: wheels and gyro alone know less than a tolerance of 0.25 m asks for
            share_of("ends truly within 0.25 m", lambda case: case["true_distance"] <= 0.25, at_least=0.55),
            all_of("never reached, unless it truly is there", truly_there),
            # it drives at 0.25 m/s at most, and its corners turn as fast again
            worst_of("contact by its own motion [m/s]", lambda case: case["contact_speed"], at_most=0.45),
            share_of("without any contact", lambda case: case["contact_speed"] == 0.0, at_least=0.30),
        ],
    ),
    *(
        Experiment(
            f"explore {scene}",
            explore,
            {"scene": scene},
            cases=20,
            sample=2,
            rows=[
                worst_of(
                    "coverage in 1.5 times what nearest-frontier takes", lambda case: case["coverage"], at_least=0.97
                ),
                worst_of("contact by its own motion [m/s]", lambda case: case["contact_speed"], at_most=0.05),
            ],
        )
        for scene in ("office_v2", "apartment_v1", "warehouse_v1")
    ),
    *(
        Experiment(
            f"two {whom} explore office_v2",
            explore_together,
            {"scene": "office_v2", "strangers": whom == "strangers"},
            cases=60,
            sample=2,
            rows=[worst_of("contact by their own motion [m/s]", lambda case: case["contact_speed"], at_most=0.05)],
        )
        for whom in ("robots that share a map frame", "strangers")
    ),
    Experiment(
        "people in dynamic_v1",
        among_people,
        {"seconds": 300},
        cases=20,
        sample=1,
        rows=[
            ratio("in sight within 5 m, and not tracked", "missed", "seen", at_most=0.10),
            ratio("tracks with nobody within 0.5 m", "ghosts", "tracks", at_most=0.10),
            ratio("tracks that never were with anybody", "false_tracks", "people", at_most=0.15),
            mean_of("position off, RMS [m]", lambda case: case["position"], at_most=0.20),
            mean_of("velocity off, RMS [m/s]", lambda case: case["velocity"], at_most=0.60),
            mean_of("somebody waits for the robot [s a minute]", lambda case: case["waiting"], at_least=1.0),
            worst_of("contact by its own motion [m/s]", lambda case: case["contact"], at_most=0.1),
        ],
    ),
    Experiment(
        "honesty",
        lies,
        cases=100,
        sample=4,
        rows=[all_of("same commands when the truth is shifted and people scrambled", lambda case: case["equal"])],
    ),
]
