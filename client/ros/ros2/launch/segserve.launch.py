# SPDX-License-Identifier: Apache-2.0
"""Segments the clouds of one topic: ros2 launch segserve_ros segserve.launch.py points:=/camera/depth/color/points"""
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

# Name, default, description with its unit.
PARAMETERS = (("address", "127.0.0.1:50051", "the servers, as host:port, with commas between several"),
              ("view", "", "camera, world or world:X,Y,Z in meters; unset: the frame and the points tell"),
              ("method", "border", "how the dissimilarity of two regions is measured"),
              ("time_to_live", "0.5", "seconds after which a result is of no use"),
              ("track", "false", "objects keep their ids from cloud to cloud"))


def generate_launch_description():
    arguments = [DeclareLaunchArgument("points", default_value="/camera/depth/color/points",
                                       description="topic of the clouds, sensor_msgs/PointCloud2")]
    arguments += [DeclareLaunchArgument(name, default_value=default, description=text)
                  for name, default, text in PARAMETERS]
    parameters = {name: ParameterValue(LaunchConfiguration(name), value_type=str) for name, _, _ in PARAMETERS}
    node = Node(package="segserve_ros", executable="segserve_node", name="segserve", output="screen",
                parameters=[parameters], remappings=[("points", LaunchConfiguration("points"))])
    return LaunchDescription([*arguments, node])
