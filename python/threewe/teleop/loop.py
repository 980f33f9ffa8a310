"""The control loop of teleoperation: a person drives, or a policy does until the person takes over."""

from __future__ import annotations

import enum
from collections.abc import Awaitable, Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Protocol

from numpy.typing import ArrayLike

from threewe._arguments import as_function, as_seconds, as_text
from threewe._core import Intervention, TickView, Velocity
from threewe.errors import ContractError, ThreeweError
from threewe.robot import Robot
from threewe.teleop.controls import Controls
from threewe.teleop.events import Command, Connection, TeleopInput
from threewe.teleop.pilots import AutonomyPilot, Pilot, PolicyPilot

CONTROL_PERIOD = 0.02
"""[s] of robot time between two polls of the input device: every tick of the robot."""
HOLD = 0.2
"""[s] of robot time that a velocity holds. A program that hangs or dies leaves the robot standing after it."""

Policy = Callable[[Any], Awaitable[ArrayLike]]
"""From what `robot.get_observation()` gives to an action, (3,) in [-1, 1] of the operating limits."""
Autonomy = Callable[[], Awaitable[object]]
"""Starts what drives the robot by itself, such as `robot.explore`; it is cancelled when a person takes over."""


class EpisodeRecorder(Protocol):
    """What teleoperation needs of a recorder of episodes, such as `threewe.data.TrajectoryRecorder`."""

    @property
    def recording(self) -> bool:
        """Whether an episode is being recorded."""

    def start_episode(self, *, task: str) -> object:
        """Begins an episode of a task."""

    def end_episode(self, *, success: bool) -> object:
        """Ends it and keeps it."""

    def discard_episode(self) -> object:
        """Ends it and forgets it."""

    def set_takeover(self, takeover: bool, /) -> object:
        """Says whether a person drives, from the next tick on. Called outside of episodes, too."""


class Driver(enum.StrEnum):
    """Who drives the robot."""

    person = "person"
    policy = "policy"


@dataclass(frozen=True)
class Status:
    """One control period of teleoperation."""

    now: float
    """[s] of robot time"""
    driver: Driver
    """who drove in it"""
    requested: Velocity
    """[m/s, m/s, rad/s] before the safety gate"""
    executed: Velocity
    """after it"""
    intervention: Intervention
    """why the gate changed it"""
    level: int
    """of the speed, 1 to 9"""
    linear_speed: float
    """[m/s] at this level"""
    angular_speed: float
    """[rad/s] at this level"""
    emergency_stopped: bool
    """whether the emergency stop is latched"""
    connected: bool
    """whether the input device is there"""
    recording: bool
    """whether an episode is being recorded"""
    episodes: int
    """that were kept so far"""
    message: str
    """what happened last, one line for the person"""


async def teleoperate(
    robot: Robot,
    source: TeleopInput,
    *,
    recorder: EpisodeRecorder | None = None,
    policy: Policy | None = None,
    autonomy: Autonomy | None = None,
    task: str = "teleoperation",
    level: int = 5,
    policy_period: float = 0.1,
    on_status: Callable[[Status], object] | None = None,
) -> int:
    """Drives a connected robot as an input device says, until it says `quit`.

    All goes through the safety gate: velocities are asked for anew in each control period and hold for 0.2 s, so that
    the robot stops when this program does. A `policy` or an `autonomy` drives in the beginning and whenever it is
    handed back; a direction, a stop or a lost device takes over from it, from the next tick on. An episode that is
    being recorded at the end is left to the recorder's owner. The robot stands still in the end, whatever ended it.

    Args:
        robot: connected.
        source: the input device; its owner closes it.
        recorder: gets the episodes that the person begins and ends, and who drives.
        policy: an async function from observation to action, (3,) in [-1, 1], scaled to the operating limits as by
            `robot.execute_action`; called every `policy_period` [s] of robot time.
        autonomy: in place of a policy, an async function that drives the robot itself.
        task: of the episodes.
        level: the speed in the beginning, 1 to 9.
        policy_period: [s] of robot time.
        on_status: called after every tick with a Status.

    Returns:
        How many episodes were kept.

    Raises:
        ContractError: arguments that contradict each other, or an action that is not (3,) finite numbers.
        ConnectionError: not connected, or the robot was lost.
        Exception: whatever the policy, the recorder or `on_status` raised.
    """
    if policy is not None and autonomy is not None:
        raise ContractError("either a policy drives or an autonomy: give one of them")
    session = _Session(robot, source, recorder, Controls(robot.profile, level), as_text("task", task))
    if policy is not None:
        session.autopilot = PolicyPilot(
            robot, as_function("policy", policy), as_seconds("policy_period", policy_period)
        )
    elif autonomy is not None:
        session.autopilot = AutonomyPilot(as_function("autonomy", autonomy))
    await session.run(None if on_status is None else as_function("on_status", on_status))
    return session.episodes


class _Session:
    """One run of `teleoperate`."""

    def __init__(
        self,
        robot: Robot,
        source: TeleopInput,
        recorder: EpisodeRecorder | None,
        controls: Controls,
        task: str,
    ) -> None:
        self.robot, self.source, self.recorder, self.controls, self.task = robot, source, recorder, controls, task
        self.autopilot: Pilot | None = None
        self.episodes = 0
        self._driver = Driver.person
        self._connected = True
        self._message = ""
        self._tick: TickView | None = None

    async def run(self, on_status: Callable[[Status], object] | None) -> None:
        number = self.robot.observe(self._keep)
        try:
            self._set_driver(Driver.person if self.autopilot is None else Driver.policy)
            while await self._follow_events():
                self._command()
                driver = self._driver
                await self.robot.sleep(CONTROL_PERIOD)
                if on_status is not None:
                    on_status(self._status(driver))
        finally:
            with suppress(ThreeweError):  # a robot that was lost has stopped by itself
                self.robot.stop()
                self.robot.unobserve(number)
            if self.autopilot is not None:
                await self.autopilot.stop()

    def _keep(self, tick: TickView) -> None:
        self._tick = tick

    async def _follow_events(self) -> bool:
        """What the person did since the last tick; false where that was to quit."""
        events = self.source.poll(self.robot.now)
        for event in events:
            if isinstance(event, Connection):
                self._connected, self._message = event.connected, event.message
        commands, wants_to_drive = self.controls.apply(events)
        if wants_to_drive and self._driver is Driver.policy:
            await self._take_over()
        for command in commands:
            if command is Command.quit:
                return False
            self._follow(command)
        return True

    async def _take_over(self) -> None:
        self._set_driver(Driver.person)
        self._message = "you drive: t hands back"
        self.robot.stop()
        assert self.autopilot is not None
        await self.autopilot.stop()

    def _follow(self, command: Command) -> None:
        if command is Command.emergency_stop:
            self._toggle_emergency_stop()
        elif command is Command.hand_back:
            self._hand_back()
        elif command is Command.start_episode:
            self._start_episode()
        elif command in (Command.end_with_success, Command.end_with_failure, Command.discard_episode):
            self._end_episode(command)

    def _toggle_emergency_stop(self) -> None:
        if self.robot.emergency_stopped:
            self.robot.release_emergency_stop()
            self._message = "emergency stop released"
        else:
            self.robot.emergency_stop()
            self._message = "emergency stop: x releases it"

    def _hand_back(self) -> None:
        if self.autopilot is None:
            self._message = "there is no policy to hand back to"
        elif self.robot.emergency_stopped:
            self._message = "release the emergency stop first: x"
        elif self._driver is Driver.person:
            self._set_driver(Driver.policy)
            self._message = "the policy drives: any drive key takes over"

    def _start_episode(self) -> None:
        if self.recorder is None:
            self._message = "nothing is recorded here: threewe data record does"
        elif self.recorder.recording:
            self._message = "an episode is being recorded already: Enter, f or Backspace ends it"
        else:
            self.recorder.start_episode(task=self.task)
            self.recorder.set_takeover(self._driver is Driver.person)  # a new episode may begin without
            self._message = f"episode {self.episodes + 1} begins"

    def _end_episode(self, command: Command) -> None:
        if self.recorder is None or not self.recorder.recording:
            self._message = "no episode is being recorded"
        elif command is Command.discard_episode:
            self.recorder.discard_episode()
            self._message = "episode discarded"
        else:
            success = command is Command.end_with_success
            self.recorder.end_episode(success=success)
            self.episodes += 1
            self._message = f"episode {self.episodes} kept: {'success' if success else 'failure'}"

    def _set_driver(self, driver: Driver) -> None:
        self._driver = driver
        if self.recorder is not None:
            self.recorder.set_takeover(driver is Driver.person)

    def _command(self) -> None:
        """Asks for the velocity of the next tick."""
        if self._driver is Driver.policy:
            assert self.autopilot is not None
            self.autopilot.start()
            velocity = self.autopilot.velocity()
            if self.autopilot.finished:
                self._set_driver(Driver.person)
                self._message = "the autonomy has ended: you drive"
        else:
            velocity = self.controls.velocity()
        if velocity is not None and not self.robot.emergency_stopped:
            self.robot.set_velocity(*velocity, hold=HOLD)

    def _status(self, driver: Driver) -> Status:
        tick, controls = self._tick, self.controls
        return Status(
            now=self.robot.now,
            driver=driver,
            requested=Velocity() if tick is None else tick.requested,
            executed=Velocity() if tick is None else tick.commanded,
            intervention=Intervention.none if tick is None else tick.intervention,
            level=controls.level,
            linear_speed=controls.linear_speed,
            angular_speed=controls.angular_speed,
            emergency_stopped=self.robot.emergency_stopped,
            connected=self._connected,
            recording=self.recorder is not None and self.recorder.recording,
            episodes=self.episodes,
            message=self._message,
        )
