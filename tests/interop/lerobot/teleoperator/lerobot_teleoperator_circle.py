"""A teleoperator of LeRobot that always drives a circle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from lerobot.teleoperators import Teleoperator, TeleoperatorConfig


@TeleoperatorConfig.register_subclass("circle")
@dataclass(kw_only=True)
class CircleConfig(TeleoperatorConfig):
    pass


class Circle(Teleoperator):
    config_class = CircleConfig
    name = "circle"
    is_connected = is_calibrated = True
    feedback_features: dict[str, Any] = {}  # noqa: RUF012

    @property
    def action_features(self) -> dict[str, Any]:
        return dict.fromkeys(("vx.vel", "vy.vel", "omega.vel"), float)

    def get_action(self) -> dict[str, Any]:
        return {"vx.vel": 0.2, "vy.vel": 0.0, "omega.vel": 0.5}

    def connect(self, calibrate: bool = True) -> None:
        pass

    def calibrate(self) -> None:
        pass

    def configure(self) -> None:
        pass

    def send_feedback(self, feedback: dict[str, Any]) -> None:
        pass

    def disconnect(self) -> None:
        pass
