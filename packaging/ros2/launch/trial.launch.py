"""ros2 launch seatrial_ros trial.launch.py namespace:=boat parameters:=boat.yaml"""

import pathlib

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

EXAMPLE = pathlib.Path(__file__).parents[1] / "config" / "two_thrusters.yaml"


def generate_launch_description():
    return LaunchDescription(
        [
            DeclareLaunchArgument("namespace", default_value=""),
            DeclareLaunchArgument("parameters", default_value=str(EXAMPLE)),
            Node(
                package="seatrial_ros",
                executable="trial",
                name="seatrial",
                namespace=LaunchConfiguration("namespace"),
                parameters=[LaunchConfiguration("parameters")],
                output="screen",
            ),
        ]
    )
