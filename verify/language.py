"""Commands in English: drawn plans come back from their sentences, handwritten ones are read as they were meant."""

import subprocess

from verify.cases.end_to_end_hash import instruct_in_false_truth, processors, targets
from verify.cases.finding import SCENES, find
from verify.cases.handwritten_commands import PARTS, read_handwritten
from verify.cases.models import DIALECTS, answer_hostile, drive_as_ours, fail_server, replay_talk
from verify.cases.routes import follow, go_to
from verify.cases.seeing import GENERATED, SUFFIX, map_things, see
from verify.cases.trees import PROGRAMS
from verify.harness import (
    Case,
    Experiment,
    Row,
    all_of,
    counted_of,
    each,
    info,
    known_miss,
    share_of,
    time_of,
    whole_of,
    worst_of,
)

EACH = 50  # commands of a case
WITH_ROUTES = ("office_v2", "apartment_v1", "generated")
WITH_ROOMS = (*WITH_ROUTES, "warehouse_v1")


def read_drawn(seed: int) -> Case:
    """Drawn commands, and how many of them were read as the right plan, or as a wrong one instead of a question."""
    command = [str(PROGRAMS / "verify_commands"), str(seed), str(EACH)]
    lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    counts = {name: int(value) for name, _, value in (line.partition(" ") for line in lines) if name != "lost"}
    return {"commands": EACH, "lost": [line for line in lines if line.startswith("lost ")], **counts}


def share(hits: str, name: str, **target: float) -> Row:
    """A share of the commands of all cases."""
    return counted_of(name, lambda case: case[hits], lambda case: case["commands"], **target)


def share_counted(hits: str, of: str, name: str, at_least: float) -> Row:
    """The share of what the cases count."""
    return counted_of(name, lambda case: case[hits], lambda case: case[of], at_least=at_least)


FIRST = "the detector has learnt in generated buildings, which are barer than these scenes"
SHAPES = "what it was not trained on it takes for other kinds"
MIXED = "what is in a shelf, and the floor between legs, counts for the color of a thing"


def figures(program: str, *arguments: object) -> Case:
    """What a program prints, a figure a line."""
    command = [str(PROGRAMS / program), *map(str, arguments)]
    output = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return {name: float(value) for name, value in (line.split() for line in output.splitlines())}


def time_a_look(seed: int) -> Case:
    """What one look of the detector takes."""
    return figures("verify_detector", seed, "--time")


def time_instructions(seed: int) -> Case:
    """How many times real time a search and an exploration run, and how far the robot came."""
    return figures("verify_agent", seed, "--speed")


def among() -> Row:
    """The vector targets that all cases had."""
    return info("targets", lambda cases: ", ".join(sorted(set.intersection(*(set(c["targets"]) for c in cases)))))


def found(at_least: float) -> Row:
    """The share of searches that end in success."""
    return share_of("found, by the rule of 3we/ObjectNav-v1", lambda case: case["found"], at_least=at_least)


def wrong() -> Row:
    """The share of searches that end with a claim that is verified, and wrong."""
    return counted_of("claimed, verified and wrong", lambda case: case["claimed_wrong"], lambda _: 1.0, at_most=0.03)


def enough(name: str, of: str, count: int) -> Row:
    """What all cases count is so much at least."""

    def judge(cases: list[Case]) -> tuple[str, str, bool]:
        counted = sum(case[of] for case in cases)
        return f"{counted:,}", f">= {count:,}", counted >= count

    return whole_of(name, judge)


EXPERIMENTS = [
    Experiment(
        "commands, drawn from the lexicon",
        read_drawn,
        cases=40,
        rows=[
            share("right", "drawn commands read as the right plan", at_least=0.995),
            share("wrong_plan", "a wrong plan instead of a question", at_most=0.02),
        ],
    ),
    Experiment(
        "commands, written by hand",
        read_handwritten,
        variants=[{"part": part} for part in range(PARTS)],
        cases=PARTS,
        rows=[
            share("right", "handwritten commands read as the right plan", at_least=0.95),
            share("wrong_plan", "a wrong plan instead of a question", at_most=0.02),
        ],
    ),
    *(
        Experiment(
            f"things in pictures of scenes that the detector has not seen{shapes}",
            see,
            variants=[{"scene": f"{scene}{suffix}"} for scene in SCENES],
            cases=50 * len(SCENES),
            rows=[
                known_miss(share_counted("right", "named", "kinds that are named are right", 0.9), precision, SHAPES),
                known_miss(share_counted("found", "things", "things are found, by their kind", 0.4), recall, FIRST),
                known_miss(share_counted("colors_right", "colors", "their color terms are right", 0.95), color, MIXED),
            ],
        )
        for shapes, suffix, precision, recall, color in [
            ("", "", None, 2696 / 8068, 2502 / 2696),
            (", held-out shapes", SUFFIX, 1526 / 2166, 1525 / 7937, 1439 / 1525),
        ]
    ),
    Experiment(
        "pictures of a scene, by the detector on every vector target",
        targets,
        {"program": "verify_detector"},
        cases=20,
        rows=[all_of("the same bits", lambda case: case["equal"] and len(case["targets"]) >= 2), among()],
    ),
    Experiment(
        "aarch64, emulated: pictures of a scene, by the detector",
        processors,
        {"program": "verify_detector"},
        cases=5,
        rows=[all_of("the same bits as on this processor", lambda case: case["equal"])],
    ),
    Experiment(
        "one look of the detector, on one core",
        time_a_look,
        cases=5,
        rows=[time_of("a look [ms of CPU time]", lambda case: case["milliseconds"], at_most=10.0)],
        alone=True,
    ),
    *(
        Experiment(
            f"the semantic map after exploring {where}",
            map_things,
            variants=[{"scene": scene} for scene in scenes],
            cases=40,
            rows=[
                known_miss(
                    share_counted("right", "entries", "entries are of a thing of that kind", 0.9), precision, FIRST
                ),
                known_miss(share_counted("known", "things", "things that were in view are in it", 0.7), recall, FIRST),
            ],
        )
        for where, scenes, precision, recall in [
            ("generated buildings", [GENERATED], None, None),
            ("scenes that the detector has not seen", SCENES, 2392 / 2691, 2008 / 3067),
        ]
    ),
    *(
        Experiment(
            f"find the {what}, in an unknown map: no doors, and from 2 m of way on",
            find,
            {"colored": colored},
            variants=[{"scene": scene} for scene in SCENES],
            cases=100 * len(SCENES),
            rows=[
                found(0.7),
                *each("scene", SCENES, lambda scene, known=known: known_miss(found(0.6), known.get(scene), MIXED)),
                known_miss(wrong(), known.get("wrong"), MIXED),
            ],
        )
        for what, colored, known in [
            ("KIND", False, {}),
            ("COLOR KIND", True, {"warehouse_v1": 57 / 100, "wrong": 33 / 400}),
        ]
    ),
    Experiment(
        "routes of 3we/VLN-v1, in an unknown map, with the borders of rooms",
        follow,
        variants=[{"place": place} for place in WITH_ROUTES],
        cases=50 * len(WITH_ROUTES),
        rows=[share_of("ended within 1 m of the path's end", lambda case: case["success"], at_least=0.6)],
    ),
    Experiment(
        "routes of another episode of 3we/VLN-v1",
        follow,
        variants=[{"place": place, "shuffled": True} for place in WITH_ROUTES],
        cases=50 * len(WITH_ROUTES),
        rows=[
            counted_of(
                "ended there by a text that is not of the episode",
                lambda case: case["success"],
                lambda _: 1.0,
                at_most=0.3,
            )
        ],
    ),
    Experiment(
        "go to the PLACE, map and places given",
        go_to,
        variants=[{"place": place} for place in WITH_ROOMS],
        cases=50 * len(WITH_ROOMS),
        rows=[share_of("stood in the place", lambda case: case["success"], at_least=0.97)],
    ),
    Experiment(
        "instructions where the truth is moved by 100 m, and what is named goes by other names",
        instruct_in_false_truth,
        cases=100,
        rows=[
            all_of("the same commands, to the bit", lambda case: case["equal"]),
            all_of("an agent that peeks at things is found out", lambda case: case["found_out"]),
        ],
    ),
    Experiment(
        "offline instructions in office_v2, detector and autonomy on, on one core",
        time_instructions,
        cases=5,
        rows=[
            time_of("robot seconds a CPU second", lambda case: case["times"], at_least=20.0),
            worst_of("really driven meanwhile [m]", lambda case: case["metres"], at_least=10.0),
        ],
        alone=True,
    ),
    Experiment(
        "a model as good as ours, behind HTTP",
        drive_as_ours,
        variants=[{"dialect": dialect} for dialect in DIALECTS],
        cases=20 * len(DIALECTS),
        rows=[all_of("in every dialect the offline run, to the bit", lambda case: case["same"])],
    ),
    Experiment(
        "hostile answers of a model",
        answer_hostile,
        cases=600,
        rows=[
            share_counted("one_reason", "instructions", "each ends with one reason within its budget", 1.0),
            worst_of("commands, as a share of the operating limits", lambda case: case["fastest"], at_most=1.0 + 1e-9),
            worst_of("driven in a keep-out zone [m]", lambda case: case["in_zone"], at_most=0.0),
            worst_of("contacts [m/s]", lambda case: case["contact"], at_most=0.05),
            all_of("the emergency stop stays latched", lambda case: case["unlatched"] == 0),
            enough("hostile answers that a model gave", "outputs", 10_000),
        ],
    ),
    Experiment(
        "faults of a model's server",
        fail_server,
        cases=250,
        rows=[share_counted("right", "faults", "the next try works, or `model_error` says what", 1.0)],
    ),
    Experiment(
        "conversations with a model, replayed without a server",
        replay_talk,
        cases=100,
        rows=[all_of("the same bits", lambda case: case["same"])],
    ),
]
