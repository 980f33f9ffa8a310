"""Wake up in an unknown place, look around until nothing is left to see, and come back."""

import asyncio
import sys

from threewe import CoverageMeter, Progress, Robot

QUICK = "--quick" in sys.argv


async def main() -> None:
    async with Robot(scene="office_v2", seed=7) as robot:
        truth = robot.simulation
        assert truth is not None
        meter = CoverageMeter(truth)
        printed = robot.now

        # called ten times a second of robot time; the truth is for us to see, not for the robot
        def look(progress: Progress) -> None:
            nonlocal printed
            meter.observe(truth.true_pose())
            if robot.now >= printed + 5.0:
                printed = robot.now
                coverage = meter.coverage(robot.get_map())
                print(f"{printed:5.0f} s: {progress.distance_driven:5.1f} m driven, {coverage:4.0%} seen")

        seen = await robot.explore(timeout=20.0 if QUICK else 600.0, on_progress=look)
        print(f"{seen.reason.name}: {seen.explored_area:.0f} m^2 seen in {seen.duration:.0f} s")

        back = await robot.move_to(0.0, 0.0)
        print(f"back at the start: {back.success}, {back.distance_to_goal:.2f} m off")


asyncio.run(main())
