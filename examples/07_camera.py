"""See: colour and depth of an RGB-D camera, points in space, and what the simulator knows about each pixel."""

import asyncio
import sys

import numpy as np
from threewe import Robot

QUICK = "--quick" in sys.argv


async def main() -> None:
    async with Robot(hardware="3we_depth_v2", scene="apartment_v1") as robot:
        await robot.rotate(0.5 if QUICK else 2.0)

        # colours are blue, green, red; depth is in metres along the optical axis, 0 where nothing was measured
        image = robot.get_rgbd_image()
        assert image.depth is not None
        print(f"{image.color.shape} {image.color.dtype}, {np.mean(image.depth > 0):.0%} of it with depth")

        # every pixel with depth is a point: x forward, y left, z up, from the camera
        camera = image.intrinsics
        rows, columns = np.nonzero(image.depth)
        x = image.depth[rows, columns]
        y = -(columns + 0.5 - camera.cx) / camera.fx * x
        z = -(rows + 0.5 - camera.cy) / camera.fy * x
        assert robot.profile.camera is not None
        above_floor = z + robot.profile.camera.mount_height > 0.05
        nearest = np.argmin(np.where(above_floor, np.hypot(x, y), np.inf))
        print(f"nearest thing: {x[nearest]:.2f} m ahead, {y[nearest]:.2f} m to the left")

        # the truth, which robots never see: for training, and for metrics
        assert robot.simulation is not None
        truth = robot.simulation.look()
        names, pixels = np.unique(truth.ids, return_counts=True)
        for name in names[np.argsort(-pixels)][:5]:
            print(f"in sight: {truth.names[name]}")


asyncio.run(main())
