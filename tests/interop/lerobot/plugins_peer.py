"""LeRobot 0.6.1 has our robot and our environment, in its own Python: drives, and looks at what is red and of wood."""

import time

import gymnasium
import numpy as np
from threewe import Features, Pose2D, SensorInfo, SensorType, register_backend
from threewe.backend import Backend, CameraReading, LidarReading, OdometryReading

from lerobot.envs.configs import EnvConfig
from lerobot.robots.config import RobotConfig
from lerobot.robots.utils import make_robot_from_config
from lerobot.utils.import_utils import register_third_party_plugins

SIZE = [60, 80]


class Red(Backend):
    """A robot that stands before a red wall."""

    @property
    def features(self):
        """A camera, and what every robot has."""
        sensors = [
            SensorInfo("lidar", SensorType.lidar, 10.0),
            SensorInfo("odometry", SensorType.odometry, 50.0),
            SensorInfo("camera", SensorType.camera, 50.0),
        ]
        return Features(sensors, self.profile.kinematics, lockstep=True)

    def connect(self):
        """Nothing is to be done."""

    def disconnect(self):
        """Nothing is to be done."""

    def step(self, t, velocity):
        """All sensors, in each tick."""
        red = np.zeros((*SIZE, 3), np.uint8)
        red[:, :, 2] = 200  # BGR
        lidar = self.profile.lidar
        yield OdometryReading(measured=t, pose=Pose2D(), velocity=velocity)
        yield LidarReading(measured=t, ranges=np.full(lidar.beams, lidar.range_max, np.float32))
        yield CameraReading(measured=t, color=red)


def connected(**options):
    """Our robot, by LeRobot's means."""
    return make_robot_from_config(RobotConfig.get_choice_class("threewe")(id="ours", image_size=SIZE, **options))


def see_wood():
    """In the pictures of the environment nine things of wood of ten are more red than blue: they are RGB."""
    config = EnvConfig.get_choice_class("threewe")(episodes="in_sight_v1", count=20, height=SIZE[0], width=SIZE[1])
    env = gymnasium.make(f"{config.package_name}/{config.task}", **config.gym_kwargs).unwrapped
    warmth = []
    for episode in range(20):
        picture = env.reset(seed=episode)[0]["pixels"]["camera"].astype(float)
        look = env._robot.simulation.look()
        for thing in env._robot.simulation.scene.objects:
            pixels = picture[look.ids == look.names.index(thing.name)]
            if len(pixels) >= 40 and all(prism.material == "wood" for prism in thing.prisms):
                red, _, blue = pixels.mean(axis=0)
                warmth.append(red - blue)
    env.close()
    assert len(warmth) >= 10, warmth
    assert np.mean(np.array(warmth) > 0) > 0.9, warmth


def main():
    """Says `driven`, `red` and `wood`."""
    register_third_party_plugins()
    robot = connected(scene="apartment_v1")
    print(robot.observation_features, robot.action_features)
    with robot:
        for _ in range(20):
            sent = robot.send_action({"vx.vel": 9.0, "vy.vel": 0.0, "omega.vel": 0.0})
            time.sleep(0.05)
        seen = robot.get_observation()
    assert 0.2 < sent["vx.vel"] < 2.0, sent
    assert seen["vx.vel"] > 0.1, seen
    assert seen["camera"].shape == (*SIZE, 3)
    with connected(hardware="turtlebot_like") as robot:
        assert list(robot.action_features) == ["vx.vel", "omega.vel"], robot.action_features
        assert robot.send_action({"vx.vel": 0.1, "omega.vel": 0.2}) == {"vx.vel": 0.1, "omega.vel": 0.2}
    print("driven")

    register_backend("red", Red)
    with connected(backend="red") as robot:
        time.sleep(0.3)
        picture = robot.get_observation()["camera"]
    assert picture[0, 0].tolist() == [200, 0, 0], picture[0, 0]  # RGB
    print("red")

    see_wood()
    print("wood")


if __name__ == "__main__":
    main()
