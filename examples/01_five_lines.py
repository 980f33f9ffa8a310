"""Drive to a place two metres ahead and one to the left."""

import asyncio

from threewe import Robot


async def main() -> None:
    async with Robot(backend="mock") as robot:
        result = await robot.move_to(x=2.0, y=1.0)
        print(f"Success: {result.success}")


asyncio.run(main())
