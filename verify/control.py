"""The controller that robots drive with, alone: through doors, round boxes and people, out of dead ends."""

import json
import subprocess

from verify.cases.trees import PROGRAMS
from verify.harness import Case, Experiment, Row, each, known_miss, share_of, share_within, within

STANDARD, TURTLEBOT = "3we_standard_v2", "turtlebot_like"
NARROW = "a door 5 cm wider than the robot"
BUT_NARROW = f"all but {NARROW}"
ALONE = "robots pass such doors by another behaviour, which `navigation` measures; this is the controller alone"
COURSES = ("a door 20 cm wider than the robot", "a slalom", "people who cross", "a dead end")


def drive_courses(seed: int) -> Case:
    """What came of the courses of one seed, with both robots."""
    lines = subprocess.run([PROGRAMS / "verify_control", str(seed)], capture_output=True, text=True, check=True).stdout
    return {"drives": [json.loads(line) for line in lines.splitlines()]}


def all_drives(case: Case) -> list[Case]:
    drives: list[Case] = case["drives"]
    return drives


def drives_of(case: Case) -> list[Case]:
    """All but those through a door that is hardly wider than the robot."""
    return [drive for drive in all_drives(case) if drive["course"] != NARROW]


def touches_gently(drive: Case) -> bool:
    return bool(drive["contact_speed"] <= 0.05)


def arrived(drive: Case) -> bool:
    return bool(drive["arrived"])


def comes_to_the_end() -> Row:
    return share_of("comes to the end", arrived, at_least=0.85)


EXPERIMENTS = [
    Experiment(
        "courses",
        drive_courses,
        cases=100,
        rows=[
            *(
                share_within(
                    f"{BUT_NARROW}: {robot} comes to the end",
                    lambda case, robot=robot: [drive for drive in drives_of(case) if drive["hardware"] == robot],
                    arrived,
                    at_least=enough,
                )
                for robot, enough in ((STANDARD, 0.99), (TURTLEBOT, 0.90))
            ),
            # people give way to nothing here, and no gate watches over the robot
            share_within(
                f"{BUT_NARROW}: touches nothing faster than 0.05 m/s", drives_of, touches_gently, at_least=0.97
            ),
            *each("course", COURSES, lambda _: within(comes_to_the_end(), drives_of)),
            *each(
                "course",
                [NARROW],
                lambda _: within(known_miss(comes_to_the_end(), 100 / 200, ALONE), all_drives),
            ),
        ],
    )
]
