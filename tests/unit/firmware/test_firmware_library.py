"""How the firmware's library is found, built and refused."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from target_nav.config import Config
from target_nav.errors import DeviceError
from target_nav.sim import firmware_library
from target_nav.sim.host_firmware import HostFirmware
from tests.utils.firmware import FIRMWARE, need_make

CONFIG = Config()


@pytest.fixture
def no_compiler(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A machine with a shell's usual tools and no C++ compiler."""
    tools = tmp_path / "bin"
    tools.mkdir()
    for name in ("sh", "cat", "cksum", "uname", "dirname", "mkdir", "rm", "mv"):
        found = shutil.which(name)
        assert found is not None
        (tools / name).symlink_to(found)
    monkeypatch.setenv("PATH", str(tools))
    monkeypatch.delenv("CXX", raising=False)


def test_a_named_library_that_is_not_there_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv(firmware_library.LIBRARY_VARIABLE, str(tmp_path / "none.so"))
    with pytest.raises(DeviceError, match=r"TARGET_NAV_FIRMWARE_LIBRARY names .*none\.so"):
        firmware_library.library_path()


def test_without_a_compiler_it_says_what_to_install(no_compiler: None, tmp_path: Path) -> None:
    with pytest.raises(DeviceError, match=r"no C\+\+ compiler found .* sudo apt install g\+\+"):
        firmware_library.build(FIRMWARE, tmp_path / "fresh.so")


def test_a_library_that_is_up_to_date_needs_no_compiler(library: Path, no_compiler: None) -> None:
    before = library.stat().st_mtime_ns
    assert firmware_library.build(FIRMWARE, library) == library
    assert library.stat().st_mtime_ns == before


def test_sources_that_do_not_compile_are_told_with_the_compilers_words(tmp_path: Path) -> None:
    sources = copied_sources(tmp_path)
    (sources / "target_nav_firmware" / "text.cpp").write_text("this is no C++\n")
    with pytest.raises(DeviceError, match=r"text\.cpp"):
        firmware_library.build(sources, tmp_path / "fresh.so")
    assert not (tmp_path / "fresh.so").exists()


def test_a_change_of_the_sources_is_built_whatever_its_date(tmp_path: Path) -> None:
    sources, built = copied_sources(tmp_path), tmp_path / "fresh.so"
    firmware_library.build(sources, built)
    before = built.read_bytes()
    header = sources / "target_nav_firmware" / "config.h"
    header.write_text(header.read_text().replace('FIRMWARE_VERSION[] = "', 'FIRMWARE_VERSION[] = "9.'))
    os.utime(header, (0, 0))
    firmware_library.build(sources, built)
    assert built.read_bytes() != before


def test_an_installed_copy_is_built_into_the_users_cache(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    prefix = tmp_path / "prefix"
    module = prefix / "lib" / "python3" / "site-packages" / "target_nav" / "sim" / "firmware_library.py"
    copied_sources(prefix / "share" / "target_nav" / "deploy")
    monkeypatch.setattr(firmware_library, "_HERE", module)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.delenv(firmware_library.LIBRARY_VARIABLE, raising=False)
    path = firmware_library.library_path()
    assert path == tmp_path / "cache" / "target_nav" / "firmware" / firmware_library.LIBRARY_NAME
    assert HostFirmware(CONFIG, library=path).pwm == (0, 0, 0, 0)


def test_without_sources_it_says_where_it_looked(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(firmware_library, "_HERE", tmp_path / "a/b/c/d/e/f/g.py")
    with pytest.raises(DeviceError, match="sources are not there"):
        firmware_library.sources_folder()


def test_a_file_that_is_no_library_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "text.so"
    path.write_text("no library")
    with pytest.raises(DeviceError, match=r"text\.so is not the firmware's library"):
        HostFirmware(CONFIG, library=path)


def test_a_library_of_another_interface_is_refused(tmp_path: Path) -> None:
    need_make()
    source, built = tmp_path / "old.cpp", tmp_path / "old.so"
    source.write_text('extern "C" int tnf_abi() { return 99; }\n')
    subprocess.run(["c++", "-shared", "-fPIC", str(source), "-o", str(built)], check=True)
    with pytest.raises(DeviceError, match="has interface 99"):
        HostFirmware(CONFIG, library=built)


def copied_sources(folder: Path) -> Path:
    """A copy of the firmware's sources in `folder`/firmware."""
    leave_out = shutil.ignore_patterns("build")
    return Path(shutil.copytree(FIRMWARE, folder / "firmware", ignore=leave_out))
