"""A bag (MCAP) of a stack that runs already.

ros2 launch target_nav record.launch.py
ros2 launch target_nav record.launch.py output:=bags/tuesday topics:='/scan /odom'
"""

from launch import LaunchDescription

from target_nav.app.launch_actions import describe
from target_nav.app.launch_plan import RECORD_ARGUMENTS, plan_record


def generate_launch_description() -> LaunchDescription:
    return describe(RECORD_ARGUMENTS, plan_record)
