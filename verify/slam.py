"""How well our SLAM localises in places it has never seen and in given maps, maps logs, and is like its model."""

from verify.cases.given_maps import (
    claims_the_truth,
    finds_itself,
    honest,
    is_back,
    notices,
    of_placements,
    of_those_carried,
    placements,
    time_to_be_back,
)
from verify.cases.localization import (
    MODEL,
    SCENES,
    agrees,
    close_all_the_way,
    drives,
    errors_in,
    of_drives,
    write_model,
)
from verify.cases.logs import SURVEYS, TOURS, closed, mapped
from verify.cases.trajectories import absolute_error, honest_covariance, kept_track
from verify.harness import Experiment, all_of, median_of, share_of, worst_of

EXPERIMENTS = [
    Experiment(
        "localising",
        drives,
        cases=50,
        sample=5,
        rows=[
            *(errors_in(scene, position=0.10, heading=0.010) for scene in SCENES),
            of_drives(share_of("drives within 0.10 m from beginning to end", close_all_the_way, at_least=0.95)),
            of_drives(all_of("drives in which it is never lost", lambda drive: drive["lost"] == 0)),
            of_drives(worst_of("between corrections [s]", lambda drive: drive["period"], at_most=0.1001)),
            of_drives(worst_of("from a scan's end to its correction [s]", lambda drive: drive["delay"], at_most=0.021)),
            *agrees(MODEL, spread=0.30, correlation=0.15),
        ],
        learn=write_model,
    ),
    *(
        Experiment(
            f"ten minutes in {scene}, {noise}",
            kept_track,
            {"scene": scene, "randomization": randomization},
            cases=10,
            sample=1 if (scene, noise) == ("office_v2", "realistic") else 0,
            rows=[
                absolute_error(scene, randomization),
                honest_covariance(),
                all_of("never lost", lambda case: case["lost"] == 0),
                median_of("CPU of a robot minute [s]", lambda case: case["cpu"] / 10.0, at_most=6.0),
                median_of("CPU of a tick, 99 % of them [ms]", lambda case: case["tick"], at_most=4.0),
            ],
        )
        for noise, randomization in (("realistic", "none"), ("hard", "hard"))
        for scene in SCENES
    ),
    Experiment(
        "in maps of its own",
        placements,
        cases=10,
        sample=1,
        rows=[
            of_placements(share_of("finds itself within 10 s, standing", finds_itself, at_least=0.95)),
            of_placements(share_of("never claims a pose that is 0.3 m off", claims_the_truth, at_least=0.99)),
            of_those_carried(share_of("back within 10 s after it was carried away", is_back, at_least=0.95)),
            of_those_carried(median_of("to be back [s]", time_to_be_back, at_most=3.0)),
            of_those_carried(share_of("notices within 5 s that it was carried away", notices, at_least=0.95)),
        ],
    ),
    Experiment(
        "in maps without errors",
        placements,
        {"mind": "truth"},
        cases=5,
        sample=1,
        rows=[
            of_placements(share_of("never claims a pose that is 0.3 m off", claims_the_truth, at_least=0.99)),
            honest("squared error over covariance", low=0.3, high=4.0),
        ],
    ),
    *(
        Experiment(
            f"log of {survey}",
            mapped,
            {"survey": survey},
            cases=10,
            sample=1,
            rows=[
                worst_of("mean error of relations [m]", lambda case: case["translation"], at_most=bound),
                worst_of("mean error of relations [deg]", lambda case: case["rotation"], at_most=0.5),
                median_of("data seconds per second of one core", lambda case: case["speed"], at_least=1000.0),
            ],
            alone=True,
        )
        for survey, bound in SURVEYS.items()
    ),
    *(
        Experiment(
            f"loops closed in {scene}",
            closed,
            {"scene": scene},
            cases=100,
            sample=2,
            rows=[
                worst_of("closures off by more than 0.3 m or 5 degrees", lambda case: case["wrong"], at_most=0),
                worst_of("right closures in a run", lambda case: case["right"], at_least=5),
                worst_of("how far off a closure is [m]", lambda case: case["translation"], at_most=0.3),
            ],
        )
        for scene in TOURS
    ),
]
