"""The whole stack, from the process table that the supervisor uses as well.

ros2 launch target_nav bringup.launch.py                              the robot; an operator says GO
ros2 launch target_nav bringup.launch.py sim:=open_floor go:=true     the simulator in place of the robot
ros2 launch target_nav bringup.launch.py record:=true                 with a bag of all topics
"""

from launch import LaunchDescription

from target_nav.app.launch_actions import describe
from target_nav.app.launch_plan import BRINGUP_ARGUMENTS, plan_bringup


def generate_launch_description() -> LaunchDescription:
    return describe(BRINGUP_ARGUMENTS, plan_bringup)
