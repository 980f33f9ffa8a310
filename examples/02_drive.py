"""Drive by hand: velocities, readings, what the safety gate does about a wall, and the emergency stop.

Without `async`, as a script would: `threewe.sync.Robot` has the same methods, and each waits until it is done.
"""

import sys

from threewe import EmergencyStopError
from threewe.sync import Robot

QUICK = "--quick" in sys.argv

with Robot() as robot:
    # a velocity holds for half a second unless it is renewed
    for _ in range(5 if QUICK else 20):
        robot.set_velocity(vx=0.3, omega=0.4)
        robot.sleep(0.2)
    robot.stop()
    robot.sleep(0.5)
    pose, scan = robot.get_pose(), robot.get_lidar_scan()
    ahead = scan.ranges[round(-scan.angle_min / scan.angle_increment) % len(scan.ranges)]
    print(f"at ({pose.x:.2f}, {pose.y:.2f}), heading {pose.theta:.2f} rad; {ahead:.2f} m to what is ahead")

    # straight on until the gate says no: it stops the robot before what the lidar sees
    for _ in range(50 if QUICK else 500):
        robot.execute_action([1.0, 0.0, 0.0], period=0.04)
    assert robot.simulation is not None
    print(f"contact at {robot.simulation.max_collision_speed():.2f} m/s")

    # an emergency stop is at once and stays until it is released
    robot.emergency_stop()
    try:
        robot.set_velocity(vx=0.1)
    except EmergencyStopError as error:
        print(f"refused: {error}")
    robot.release_emergency_stop()
