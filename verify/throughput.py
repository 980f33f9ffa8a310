"""How many times faster than real time one core simulates and runs the autonomy stack. Keep the machine idle."""

import subprocess

from verify.cases.trees import PROGRAMS
from verify.harness import Case, Experiment, time_of, worst_of

PROGRAM = PROGRAMS / "verify_throughput"


def throughput(seed: int) -> Case:
    """Robot seconds per CPU second, and how far the robot came."""
    output = subprocess.run([PROGRAM, str(seed)], capture_output=True, text=True, check=True).stdout
    return {name: float(value) for name, value in (line.split() for line in output.splitlines())}


def tick(seed: int, scene: str) -> Case:
    """What 10,000 control ticks of a robot on its way from goal to goal take."""
    output = subprocess.run([PROGRAMS / "verify_tick", scene, str(seed)], capture_output=True, text=True, check=True)
    case: Case = {name: float(value) for name, value in (line.split() for line in output.stdout.splitlines())}
    print(f"    {scene}: p99 of a tick by the wall's clock {case['wall_p99_ms']} ms", flush=True)
    return case


EXPERIMENTS = [
    *(
        Experiment(
            f"a control tick, everything on, driving in {scene}",
            tick,
            {"scene": scene},
            cases=5,
            rows=[
                worst_of("p99 of thread CPU time [ms]", lambda case: case["cpu_p99_ms"], at_most=4.0),
                time_of("the worst tick of all 10,000 [ms]", lambda case: case["cpu_worst_ms"], at_most=20.0),
                worst_of("really driven meanwhile [m]", lambda case: case["metres"], at_least=25.0),
            ],
            alone=True,
        )
        for scene in ("office_v2", "dynamic_v1")
    ),
    Experiment(
        "one robot in office_v2, realistic noise",
        throughput,
        cases=7,
        rows=[
            time_of("simulation alone, times real time", lambda case: case["simulation"], at_least=300.0),
            time_of("localising and mapping, times real time", lambda case: case["autonomy"], at_least=100.0),
            time_of(
                "localising and mapping, with a camera of 640x480 at 30 Hz, times real time",
                lambda case: case["camera"],
                at_least=20.0,
            ),
            worst_of(
                "pixels really drawn a second", lambda case: case["camera_pixels_per_second"], at_least=640 * 480 * 30
            ),
            worst_of("really driven meanwhile [m]", lambda case: case["autonomy_metres"], at_least=25.0),
        ],
        alone=True,
    ),
    Experiment(
        "the whole autonomy stack of one robot in office_v2",
        tick,
        {"scene": "office_v2"},
        cases=7,
        by_night=False,  # by the wall a busy machine decides
        rows=[
            time_of("robot seconds a wall second", lambda case: case["wall_times"], at_least=100.0),
            time_of("robot seconds a CPU second", lambda case: case["cpu_times"], at_least=100.0),
            worst_of("really driven meanwhile [m]", lambda case: case["metres"], at_least=25.0),
        ],
        alone=True,
    ),
]
