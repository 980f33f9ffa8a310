"""CARMEN logs, in which most classic recordings are kept: one message a line.

The fields, as the comment at the top of each log has them; a message ends with `ipc_timestamp hostname
logger_timestamp`, of which the first is the time that relations refer to:

    PARAM name value
    ODOM x y theta tv rv accel
    FLASER num_readings [ranges] laser_x laser_y laser_theta odom_x odom_y odom_theta
    ROBOTLASER1 laser_type start_angle field_of_view angular_resolution maximum_range accuracy remission_mode
        num_readings [ranges] num_remissions [remissions] laser_x laser_y laser_theta robot_x robot_y robot_theta
        laser_tv laser_rv forward_safety_dist side_safety_dist turn_axis
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple, NoReturn

import numpy as np
from numpy.typing import NDArray

from threewe import _core
from threewe._core import LaserScan, Pose2D
from threewe._files import require_file
from threewe.errors import ConfigError, ContractError
from threewe.slam.log import Log, Progress

SICK_RANGE_MAX = 80.0  # [m] that readers assume where an old log does not tell; beyond it a SICK saw nothing
NOMINAL_PERIOD = 0.2  # [s] between scans where no stamps tell: a SICK on a serial line gives about five a second
MOST_LATE = 1 / 3  # of the scans may be no later than one before them, for stamps to be taken for a clock
LASERS = ("FLASER", "ROBOTLASER1")
OFFSETS = ("robot_frontlaser_offset", "robot_frontlaser_side_offset", "robot_frontlaser_angular_offset")
RANGE_MAX = "robot_front_laser_max"
PARAMETERS = (*OFFSETS, RANGE_MAX)  # that matter here
FARTHEST = 1000.0  # [m], [rad] that a laser is from its robot's middle, or sees
LONGEST_LINE = 2**20  # [bytes] a scan of 16384 ranges takes 200 kB
STEADY = 0.02  # [m], [rad] by which a laser may move on its robot because numbers were rounded


def read_carmen(path: Path, *, on_progress: Progress | None = None) -> Log:
    """Reads a log. A line that is cut short or holds no numbers is skipped and counted, as loggers that were stopped
    left such; a log without a single scan raises ConfigError. Where stamps do not advance, the logger's own are taken;
    where those do not either, scans are numbered, `NOMINAL_PERIOD` apart: `Log.clock` says so.
    """
    log = Log()
    parameters: dict[str, float] = {}
    messages: list[Message] = []
    lines: list[int] = []
    kind = ""
    for number, line in _lines(path, on_progress):
        words = line.split()
        name = words[0] if words else "#"
        if name == "PARAM" and len(words) > 2 and words[1] in PARAMETERS:
            parameters[words[1]] = _parameter(path, number, words)
        if name not in LASERS or (kind and name != kind):  # newer logs hold the same scan in both forms
            continue
        kind = name
        try:
            message = (_flaser if name == "FLASER" else _robotlaser)(words, parameters)
            _core.check_reading(message.scan, message.base)
            _core.check_reading(message.scan, message.laser)
        except (ValueError, IndexError, OverflowError):
            log.skip("broken lines")
            continue
        count, first = len(message.scan.ranges), len((messages or [message])[0].scan.ranges)
        if count != first:
            _fail(path, number, f"a scan of {count} ranges after scans of {first}")
        messages.append(message)
        lines.append(number)
    if not messages:
        _fail(path, 1, f"no scan in it; a CARMEN log has lines that begin with {' or '.join(LASERS)}")
    times, log.clock = _clock(path, messages, lines)
    for number, time, message in zip(lines, times, messages, strict=True):
        try:
            log.add(float(time), message.scan, message.base)
        except ContractError as error:
            _fail(path, number, str(error))
    log.base_from_lidar = _mount(parameters, [message.base.inverse() * message.laser for message in messages])
    return log


def write_carmen(path: Path, log: Log) -> None:
    """Writes scans as FLASER lines, which reading gives back to the centimetre; raises ConfigError where it could not:
    FLASER holds 180 or 181 beams a degree apart, or 360 or 361 half a degree apart, from the right to the left.
    """
    mount = log.base_from_lidar
    with path.open("w", encoding="utf-8") as file:
        file.write("# CARMEN Logfile\n# written by threewe\n")
        for name, value in zip(OFFSETS, mount, strict=True):
            file.write(f"PARAM {name} {value:.6f} 0 nohost 0\n")
        if log.scans:
            file.write(f"PARAM {RANGE_MAX} {log.scans[0].range_max:.2f} 0 nohost 0\n")
        for i, (time, scan, base) in enumerate(zip(log.times, log.scans, log.odometry, strict=True)):
            if not np.allclose([scan.angle_min, scan.angle_increment], _fan(len(scan.ranges))):
                raise ConfigError(
                    f"scan {i}: FLASER cannot hold {len(scan.ranges)} beams from {scan.angle_min:.4f} rad, "
                    f"{scan.angle_increment:.4f} rad apart"
                )
            ranges = " ".join(f"{r:.2f}" for r in scan.ranges)
            poses = " ".join(f"{value:.6f}" for pose in (base * mount, base) for value in pose)
            file.write(f"ODOM {' '.join(f'{value:.6f}' for value in base)} 0 0 0 {time:.6f} nohost {time:.6f}\n")
            file.write(f"FLASER {len(scan.ranges)} {ranges} {poses} {time:.6f} nohost {time:.6f}\n")


class Message(NamedTuple):
    """A scan as a line has it."""

    time: float  # [s] when it was measured
    logged: float  # [s] when it was written; NaN where the line does not say
    scan: LaserScan
    laser: Pose2D  # odom_from_lidar
    base: Pose2D  # odom_from_base


def _clock(path: Path, messages: list[Message], lines: list[int]) -> tuple[NDArray[np.float64], str]:
    """[s] of each scan; and where that is not its stamp, what it is and why."""
    stamps = np.array([message.time for message in messages])
    logged = np.array([message.logged for message in messages])
    late = _late(stamps)
    if late.mean() <= MOST_LATE:
        return stamps, ""
    where = f"{path}:{lines[int(late.argmax())]}: {late.sum()} of {len(late)} stamps are no later than one before them"
    if np.isfinite(logged).all() and _late(logged).mean() <= MOST_LATE:
        return logged, f"{where}: times are the logger's"
    return np.arange(
        len(messages), dtype=np.float64
    ) * NOMINAL_PERIOD, f"{where}: scans are numbered, {NOMINAL_PERIOD:g} s apart"


def _late(stamps: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which are no later than the latest before them."""
    late: NDArray[np.bool_] = np.r_[False, stamps[1:] <= np.maximum.accumulate(stamps)[:-1]]
    return late


def _flaser(words: list[str], parameters: dict[str, float]) -> Message:
    count = int(words[1])
    angle_min, increment = _fan(count)
    ranges = _numbers(words[2 : 2 + count], count)
    x, y, theta, *base, time = _numbers(words[2 + count : 9 + count], 7)
    limit = parameters.get(RANGE_MAX, SICK_RANGE_MAX)
    scan = _scan(ranges, angle_min, increment, limit)
    return Message(time, _logged(words, 10 + count), scan, Pose2D(x, y, theta), Pose2D(*base))


def _robotlaser(words: list[str], _: dict[str, float]) -> Message:
    angle_min, _fov, increment, limit = _numbers(words[2:6], 4)
    count = int(words[8])
    ranges = _numbers(words[9 : 9 + count], count)
    after = 10 + count + int(words[9 + count])  # the remissions
    tail = _numbers(words[after : after + 12], 12)
    if increment <= 0.0 or limit <= 0.0:
        raise ValueError
    scan = _scan(ranges, angle_min, increment, limit)
    return Message(tail[11], _logged(words, after + 13), scan, Pose2D(*tail[:3]), Pose2D(*tail[3:6]))


def _fan(count: int) -> tuple[float, float]:
    """[rad] of the first beam and between beams. FLASER does not tell; a SICK sweeps half a turn from its right, 1 or
    0.5 degrees a beam, and with an even count the last beam was dropped.
    """
    if count < 2:
        raise ValueError
    return -math.pi / 2, math.pi / (count - count % 2)


def _scan(ranges: NDArray[np.float64], angle_min: float, increment: float, limit: float) -> LaserScan:
    if (ranges < 0.0).any():
        raise ValueError
    return LaserScan(np.minimum(ranges, limit).astype(np.float32), angle_min, increment, 0.0, limit)


def _mount(parameters: dict[str, float], offsets: list[Pose2D]) -> Pose2D:
    """Where the laser is: by the log's parameters, else by the poses of laser and robot, if one stays on the other: in
    logs that have been corrected, one is the corrected pose of the other.
    """
    if OFFSETS[0] in parameters:
        return Pose2D(*(parameters.get(name, 0.0) for name in OFFSETS))
    differences = np.abs(np.array([tuple(offset) for offset in offsets]) - tuple(offsets[0]))
    return offsets[0] if (differences.max() < STEADY and offsets[0].distance(Pose2D()) < 2.0) else Pose2D()


def _logged(words: list[str], at: int) -> float:
    """[s] The logger's own stamp, the last word of a line."""
    try:
        return float(words[at])
    except (ValueError, IndexError):
        return math.nan


def _numbers(words: list[str], count: int) -> NDArray[np.float64]:
    numbers = np.array(words, dtype=np.float64)
    if len(numbers) != count or not np.isfinite(numbers).all():
        raise ValueError
    return numbers


def _parameter(path: Path, line: int, words: list[str]) -> float:
    try:
        value = float(words[2])
    except ValueError:
        value = math.nan
    low = FARTHEST if words[1] in OFFSETS else 0.0
    if not -low <= value <= FARTHEST:
        _fail(path, line, f"{words[1]} must be a number in [{-low:g}, {FARTHEST:g}], got {words[2][:24]!r}")
    return value


def _lines(path: Path, on_progress: Progress | None) -> Iterator[tuple[int, str]]:
    require_file(path)
    size = max(path.stat().st_size, 1)
    done = 0
    with path.open("rb") as file:
        for number, line in enumerate(iter(lambda: file.readline(LONGEST_LINE + 1), b""), 1):
            if len(line) > LONGEST_LINE:
                _fail(path, number, f"a line of more than {LONGEST_LINE} bytes: this is no CARMEN log")
            done += len(line)
            if on_progress and number % 100 == 0:
                on_progress(done / size)
            yield number, line.decode("ascii", errors="replace")


def _fail(path: Path, line: int, what: str) -> NoReturn:
    raise ConfigError(f"{path}:{line}: {what}")
