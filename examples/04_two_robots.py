"""Two robots share a world and drive at the same time."""

import asyncio

from threewe import World

STARTS = [(0.0, 0.0, 0.0), (0.0, 1.0, 0.0)]


async def main() -> None:
    # with the same poses in the scene and in their maps, both speak of the scene's frame
    world = World(robots=["3we_standard_v2", "turtlebot_like"], start_poses=STARTS, initial_poses=STARTS)
    async with world:
        first, second = world.robots
        a, b = await asyncio.gather(first.move_to(2.0, 0.0), second.move_to(2.0, 1.0))
        print(f"first:  {a.reason.name} after {a.duration:.1f} s")
        print(f"second: {b.reason.name} after {b.duration:.1f} s")


asyncio.run(main())
