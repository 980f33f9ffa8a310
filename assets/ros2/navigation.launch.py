"""Nav2 and SLAM Toolbox on a robot of `threewe ros2 serve`. Not run yet: written from the packages' documentation.

threewe ros2 serve --scene office_v2 --robot 3we_standard_v2
ros2 launch navigation.launch.py
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

HERE = Path(__file__).parent


def include(package: str, file: str, **arguments: object) -> IncludeLaunchDescription:
    """A launch file of another package, on the simulator's clock."""
    source = PythonLaunchDescriptionSource(str(Path(get_package_share_directory(package)) / "launch" / file))
    return IncludeLaunchDescription(source, launch_arguments={"use_sim_time": "true", **arguments}.items())


def generate_launch_description() -> LaunchDescription:
    """SLAM Toolbox makes /map and map -> odom, Nav2 plans and drives, RViz shows both."""
    parameters = str(Path(get_package_share_directory("nav2_bringup")) / "params" / "nav2_params.yaml")
    return LaunchDescription(
        [
            DeclareLaunchArgument("params_file", default_value=parameters, description="Nav2's parameters."),
            include("slam_toolbox", "online_async_launch.py"),
            include("nav2_bringup", "navigation_launch.py", params_file=LaunchConfiguration("params_file")),
            Node(
                package="rviz2",
                executable="rviz2",
                arguments=["-d", str(HERE / "navigation.rviz")],
                parameters=[{"use_sim_time": True}],
            ),
        ]
    )
