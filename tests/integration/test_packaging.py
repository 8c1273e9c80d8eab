"""What gets installed: by pip as a wheel, by colcon for `ros2 run`, and from which locks."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
EXECUTABLES = {"tree_executor", "camera_node", "arduino_node", "odometry_node", "detector_node", "gui", "sim"}
EXECUTABLES |= {"lidar_node", "bag_recorder"}
WATCHERS = {"py-trees-tree-watcher", "py-trees-blackboard-watcher"}
# Composed, so that a search for them finds nothing here.
REGISTRY_HOSTS = ["python" + "hosted", "py" + "pi.org", "registry." + "npm", "github" + ".com"]
LOCAL_PATHS = ["file" + "://", "/" + "root/", "/" + "home/", "/" + "opt/"]

bin_folder = Path(sys.prefix) / "bin"
needs_tools = pytest.mark.skipif(
    not (bin_folder / "colcon").exists(),
    reason="colcon is in the extra `dev`, which this environment has not",
)


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the sources, for building leaves folders behind."""
    copy = tmp_path_factory.mktemp("packaging") / "checkout"
    leave_out = shutil.ignore_patterns(".*", "__pycache__", "build", "install", "log", "runs", "*.egg-info")
    shutil.copytree(ROOT, copy, ignore=leave_out)
    return copy


def run(command: list[str | Path], folder: Path, **more: str) -> str:
    env = {**os.environ, "PATH": f"{bin_folder}{os.pathsep}{os.environ['PATH']}", **more}
    done = subprocess.run(
        [str(word) for word in command], cwd=folder, env=env, capture_output=True, text=True, timeout=100
    )
    assert done.returncode == 0, f"{command} ended with {done.returncode}:\n{done.stdout}\n{done.stderr}"
    return done.stdout


@pytest.fixture(scope="module", params=["copied", "symlinked"])
def workspace(
    request: pytest.FixtureRequest, checkout: Path, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """A folder in which colcon has built the checkout; `install/` is in it."""
    folder = tmp_path_factory.mktemp(request.param)
    bases = [f"--{base}-base={folder / base}" for base in ("build", "install")]
    mode = ["--symlink-install"] if request.param == "symlinked" else []
    out = run([bin_folder / "colcon", f"--log-base={folder / 'log'}", "build", *bases, *mode], checkout)
    assert "1 package finished" in out  # nothing else in the checkout is taken for a package
    return folder


@pytest.mark.slow
@needs_tools
def test_colcon_puts_everything_where_ros2_run_looks(workspace: Path) -> None:
    prefix = workspace / "install" / "target_nav"
    scripts = prefix / "lib" / "target_nav"
    assert {file.name for file in scripts.iterdir()} >= EXECUTABLES
    assert all(os.access(scripts / name, os.X_OK) for name in EXECUTABLES)
    assert (prefix / "share/ament_index/resource_index/packages/target_nav").is_file()
    assert (prefix / "share/target_nav/package.xml").is_file()
    assert (prefix / "share/target_nav/trees/bowling_pin.xml").is_file()
    assert (prefix / "share/target_nav/launch/bringup.launch.py").is_file()
    assert (prefix / "share/target_nav/launch/record.launch.py").is_file()
    assert (prefix / "share/target_nav/urdf/target_nav.urdf").is_file()
    assert (prefix / "share/target_nav/deploy/firmware/build-host.sh").is_file()


@pytest.mark.slow
@needs_tools
def test_a_workspace_runs_its_own_copy(workspace: Path) -> None:
    setup = workspace / "install" / "local_setup.bash"

    def sourced(*command: str | Path) -> str:
        words: list[str | Path] = ["bash", "-c", 'source "$1" && shift && "$@"', "-", setup, *command]
        return run(words, workspace, PYTHONPATH="")

    names = ("behaviours", "target_nav", "trees")
    ask = f"from importlib.util import find_spec; print(*(find_spec(name).origin for name in {names}))"
    origins = sourced("python", "-c", ask).split()
    assert [Path(file).is_relative_to(workspace) for file in origins] == [True, True, True]
    assert "run" in sourced(workspace / "install/target_nav/lib/target_nav/target-nav", "--help")
    # The simulator's firmware is built from the sources that were installed with it.
    ask = "from target_nav.sim import firmware_library as f; print(f.sources_folder(), f.firmware_version())"
    sources, version = sourced("env", f"XDG_CACHE_HOME={workspace}", "python", "-c", ask).split()
    assert re.fullmatch(r"\d+\.\d+\.\d+", version)
    assert not Path(sources).is_relative_to(ROOT)


@pytest.mark.slow
@needs_tools
def test_the_wheel_is_complete(checkout: Path, tmp_path: Path) -> None:
    options = ["--no-deps", "--no-build-isolation", "--quiet", "--wheel-dir", tmp_path]
    run([sys.executable, "-m", "pip", "wheel", *options, "."], checkout)
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
        (entry_points,) = (name for name in names if name.endswith("entry_points.txt"))
        commands = set(re.findall(r"^([\w-]+) =", archive.read(entry_points).decode(), re.MULTILINE))

    assert commands == EXECUTABLES | WATCHERS | {"target-nav"}
    for folder, pattern in [
        ("target_nav", "*.py"),
        ("behaviours", "*.py"),
        ("target_nav/sim/arenas", "*.yaml"),
        ("trees", "*.xml"),
        ("trees", "*.yaml"),
    ]:
        sources = {str(file.relative_to(checkout)) for file in (checkout / folder).rglob(pattern)}
        assert sources <= names, f"not in the wheel: {sorted(sources - names)}"
    assert not [name for name in names if name.startswith(("tests", "benchmarks", "scripts"))]


@pytest.mark.parametrize("name", ["requirements.lock", "requirements-ros.lock"])
def test_a_lock_pins_with_hashes_and_names_no_place(name: str) -> None:
    text = (ROOT / name).read_text()
    places = [place for place in [*REGISTRY_HOSTS, *LOCAL_PATHS] if place in text]
    assert not places, f"{name} would install from {places} only"
    pins = re.findall(r"^([\w.-]+)==[^\n]*\\\n    --hash=sha256:[0-9a-f]{64}", text, re.MULTILINE)
    lines = [line for line in text.splitlines() if line and not line.startswith((" ", "#"))]
    assert len(pins) == len(lines) > 20
    assert "torch" not in pins


def test_nothing_of_ros_is_required_by_a_plain_install() -> None:
    locked = (ROOT / "requirements.lock").read_text()
    assert not re.findall(r"^ros-.*$", locked, re.MULTILINE)
    assert re.findall(r"^ros-jazzy-rclpy==", (ROOT / "requirements-ros.lock").read_text(), re.MULTILINE)
