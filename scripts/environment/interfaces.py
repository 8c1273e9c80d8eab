"""tf2_msgs and py_trees_ros_interfaces, which ROS 2 from wheels lacks: built from deploy/interfaces, then cached."""

from __future__ import annotations

import os
import platform
import re
import shutil
import sys
import sysconfig
import tarfile
import tempfile
from collections.abc import Iterator
from pathlib import Path

from environment.steps import ROOT, STATE, Progress, SetupError, clean_environ, digest, output_of, run

DEFINITIONS = ROOT / "deploy" / "interfaces"
# package -> a module of it whose import loads the compiled part
PACKAGES = {"tf2_msgs": "tf2_msgs.msg", "py_trees_ros_interfaces": "py_trees_ros_interfaces.srv"}
# Stands in archived files where the environment's folder was.
PREFIX_MARK = "@TARGET_NAV_PREFIX@"


def missing(venv: Path) -> list[str]:
    """The packages that the environment's Python cannot import."""
    python = venv / "bin" / "python"
    return [name for name, module in PACKAGES.items() if output_of(python, f"import {module}") is None]


def provide(venv: Path, ros_lock: Path, progress: Progress) -> str:
    """Put both packages into an environment that has ROS from wheels; returns where they came from."""
    archive = archive_path(ros_lock)
    if unpack(archive, venv):
        return "from the cache"
    build(venv, archive, progress)
    if not unpack(archive, venv):
        raise SetupError(f"The interface packages were built but do not import: {', '.join(missing(venv))}.")
    return "built"


def archive_path(ros_lock: Path) -> Path:
    """The cached build, shared by all checkouts; its name has everything in it that the binaries depend on."""
    home = Path.home() / ".cache" if "HOME" in os.environ else STATE
    base = Path(os.environ.get("XDG_CACHE_HOME") or home)
    machine = f"{sys.implementation.cache_tag} {platform.machine()} {platform.libc_ver()}"
    key = digest(DEFINITIONS, ros_lock, Path(__file__), machine)
    return base / "target_nav" / f"interfaces-{key}.tar.gz"


def unpack(archive: Path, venv: Path) -> bool:
    """Install the archive; False when there is none, or when it does not work here and was removed."""
    if not archive.is_file():
        return False
    try:
        with tempfile.TemporaryDirectory(dir=venv) as scratch:
            with tarfile.open(archive) as tar:
                tar.extractall(scratch)
            replace_in_files(Path(scratch), PREFIX_MARK, str(venv))
            shutil.copytree(scratch, venv, symlinks=True, dirs_exist_ok=True)
    except (OSError, tarfile.TarError, EOFError):
        archive.unlink(missing_ok=True)
        return False
    if missing(venv):
        archive.unlink(missing_ok=True)
        return False
    return True


def build(venv: Path, archive: Path, progress: Progress) -> None:
    """Build and stage both packages with the environment's own CMake, and write the archive."""
    require_build_tools()
    localise_cmake_files(venv)
    env = clean_environ()
    env["PATH"] = f"{venv / 'bin'}{os.pathsep}{env.get('PATH', os.defpath)}"
    env["AMENT_PREFIX_PATH"] = env["CMAKE_PREFIX_PATH"] = str(venv)
    cmake, python = venv / "bin" / "cmake", venv / "bin" / "python"
    options: list[str | Path] = [
        "-GNinja",
        f"-DCMAKE_INSTALL_PREFIX={venv}",
        f"-DPython3_EXECUTABLE={python}",
        f"-DPYTHON_EXECUTABLE={python}",
        "-DBUILD_TESTING=OFF",
        # Unoptimised: it builds in a third of the time, and a few messages a tick cost nothing either way.
        "-DCMAKE_BUILD_TYPE=None",
    ]
    hint = "The compiler's messages are in the log."
    with tempfile.TemporaryDirectory(prefix="target_nav-") as scratch:
        stage = Path(scratch) / "stage"
        for name in PACKAGES:
            tree = Path(scratch) / name
            configure = [cmake, "-S", DEFINITIONS / name, "-B", tree, *options]
            run(configure, progress, f"Configuring {name}", hint, env)
            run([cmake, "--build", tree], progress, f"Building {name}", hint, env)
            run([cmake, "--install", tree], progress, f"Staging {name}", hint, {**env, "DESTDIR": str(stage)})
        staged = stage / venv.relative_to("/")
        replace_in_files(staged, str(venv), PREFIX_MARK)
        save(staged, archive)


def require_build_tools() -> None:
    if not any(shutil.which(name) for name in ("c++", "g++", "clang++")):
        raise SetupError(
            "No C++ compiler found (c++, g++, clang++).\n  On Debian and Ubuntu: `sudo apt install g++`."
        )
    header = Path(sysconfig.get_path("include")) / "Python.h"
    if not header.is_file():
        raise SetupError(
            f"{header} is missing, and the interface packages are C extensions.\n"
            "  On Debian and Ubuntu: `sudo apt install python3-dev`; or name another Python: PYTHON=..."
        )


def localise_cmake_files(venv: Path) -> None:
    """Put this environment's include folders where the wheels' CMake files name those of their build machine."""
    numpy_include = output_of(venv / "bin" / "python", "import numpy; print(numpy.get_include(), end='')")
    if numpy_include is None:
        raise SetupError(f"numpy does not import in {venv}.\n  Remove that folder and start again.")
    for file in (venv / "share").rglob("*.cmake"):
        text = file.read_text()
        new = re.sub(r'/opt/python/[^/;">]+/include/python3\.\d+', sysconfig.get_path("include"), text)
        new = re.sub(r'/opt/python/[^;">]+/numpy/(?:_core|core)/include', numpy_include, new)
        if new != text:
            # A new file, not a write into the old one: that may be a hard link into the installer's cache.
            fresh = file.with_name(file.name + ".new")
            fresh.write_text(new)
            os.replace(fresh, file)


def replace_in_files(folder: Path, old: str, new: str) -> None:
    """In text files only: nothing compiled names the environment, its libraries are found by LD_LIBRARY_PATH."""
    for file in files_of(folder):
        content = file.read_bytes()
        if old.encode() in content:
            file.write_bytes(content.replace(old.encode(), new.encode()))


def files_of(folder: Path) -> Iterator[Path]:
    return (f for f in folder.rglob("*") if f.is_file() and not f.is_symlink() and f.suffix != ".so")


def save(folder: Path, archive: Path) -> None:
    """Under a name of its own first, so that no other set-up ever reads half an archive."""
    archive.parent.mkdir(parents=True, exist_ok=True)
    handle, part = tempfile.mkstemp(dir=archive.parent, suffix=".part")
    os.close(handle)
    with tarfile.open(part, "w:gz", compresslevel=3) as tar:
        tar.add(folder, arcname=".")
    os.replace(part, archive)
