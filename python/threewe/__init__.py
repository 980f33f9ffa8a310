"""3we: one robot program, on simulators and on the robot."""

from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as _version

from threewe._core import (
    BatteryState,
    CameraIntrinsics,
    Episode,
    ExploreResult,
    Features,
    IMUData,
    Intervention,
    Kinematics,
    LaserScan,
    Limits,
    MoveResult,
    OccupancyGrid,
    Odometry,
    Pose2D,
    PoseEstimate,
    Progress,
    RangeData,
    Reason,
    RGBDImage,
    RobotProfile,
    Sample,
    Scene,
    SceneTables,
    SemanticImage,
    SensorHealth,
    SensorInfo,
    SensorType,
    Snapshot,
    TickView,
    TrackedPerson,
    Trouble,
    Velocity,
    Zone,
    active_target,
    add_asset_directory,
    asset_directories,
    available_targets,
    force_target,
    profile_names,
    scene_names,
)
from threewe._notebook import show
from threewe.backend import backend_names, register_backend
from threewe.errors import (
    ConfigError,
    ConnectionError,
    ContractError,
    EmergencyStopError,
    HardwareError,
    NavigationError,
    SafetyError,
    ThreeweError,
    TimeoutError,
)
from threewe.exporting import export
from threewe.gym import register_envs as _register_envs
from threewe.robot import Robot
from threewe.simulation import CoverageMeter, Simulation
from threewe.world import World

try:
    __version__ = _version("threewe")
except PackageNotFoundError:  # run from the source tree
    __version__ = "0+unknown"

_register_envs()

__all__ = [
    "BatteryState",
    "CameraIntrinsics",
    "ConfigError",
    "ConnectionError",
    "ContractError",
    "CoverageMeter",
    "EmergencyStopError",
    "Episode",
    "ExploreResult",
    "Features",
    "HardwareError",
    "IMUData",
    "Intervention",
    "Kinematics",
    "LaserScan",
    "Limits",
    "MoveResult",
    "NavigationError",
    "OccupancyGrid",
    "Odometry",
    "Pose2D",
    "PoseEstimate",
    "Progress",
    "RGBDImage",
    "RangeData",
    "Reason",
    "Robot",
    "RobotProfile",
    "SafetyError",
    "Sample",
    "Scene",
    "SceneTables",
    "SemanticImage",
    "SensorHealth",
    "SensorInfo",
    "SensorType",
    "Simulation",
    "Snapshot",
    "ThreeweError",
    "TickView",
    "TimeoutError",
    "TrackedPerson",
    "Trouble",
    "Velocity",
    "World",
    "Zone",
    "__version__",
    "active_target",
    "add_asset_directory",
    "asset_directories",
    "available_targets",
    "backend_names",
    "export",
    "force_target",
    "profile_names",
    "register_backend",
    "scene_names",
    "show",
]
