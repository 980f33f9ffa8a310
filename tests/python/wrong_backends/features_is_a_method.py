"""`features` lacks its @property."""

from threewe import Features, SensorInfo, SensorType
from toy import ToyBackend


class Wrong(ToyBackend):
    def features(self) -> Features:  # error: override
        return Features([SensorInfo("odometry", SensorType.odometry, 50.0)], self.profile.kinematics, lockstep=True)
