"""Robot time and asyncio: things that happen at the same time, time limits, and thinking.

Robot time goes by only while some task waits for it and nothing else is ready to run. So this program prints the same
lines in every run, on a fast machine and on a slow one.
"""

import asyncio
import time

from threewe import Robot, TimeoutError


async def watch(robot: Robot) -> None:
    """Looks around twice a second of robot time, while the robot drives."""
    while True:
        await robot.sleep(0.5)
        x, y, _ = robot.get_pose()
        print(f"{robot.now:5.2f} s  at ({x:.1f}, {y:.1f})")


def ask_a_model() -> str:
    """Stands for a slow call: a neural network, a language model, the internet."""
    time.sleep(0.05)
    return "left"


async def main() -> None:
    async with Robot() as robot:
        # two things at once: the watcher is cancelled when the drive is over
        watching = asyncio.create_task(watch(robot))
        result = await robot.move_to(2.0, 1.0)
        watching.cancel()
        print(f"{robot.now:5.2f} s  {result.reason.name}")

        # robot time stands still while the program waits for something else, and then makes up for it by 0.3 s
        async with robot.thinking(seconds=0.3):
            answer = await asyncio.to_thread(ask_a_model)
        print(f"{robot.now:5.2f} s  the model says {answer}")

        # a limit in robot time; what is inside is cancelled, and the robot stops
        try:
            async with robot.timeout(1.0):
                await robot.move_to(0.0, 0.0)
        except TimeoutError:
            print(f"{robot.now:5.2f} s  not there in time")

        # a group of tasks: when one fails, the others are cancelled, and with them their motions
        try:
            async with asyncio.TaskGroup() as group:
                group.create_task(robot.rotate(10.0))
                group.create_task(fail_after(robot, 0.5))
        except* LookupError as errors:
            print(f"{robot.now:5.2f} s  {errors.exceptions[0]}")


async def fail_after(robot: Robot, seconds: float) -> None:
    await robot.sleep(seconds)
    raise LookupError("nothing to be found here")


asyncio.run(main())
