"""Files that include files. What goes wrong with them is in the corpus `broken/`."""

from __future__ import annotations

import os
import sys
import types
from pathlib import Path

import pytest

from target_nav.errors import MissionError
from target_nav.mission import load_mission
from target_nav.mission.check import check_file
from target_nav.mission.includes import MAX_FILES
from tests.unit.mission.vocabulary import registry


def write(path: Path, *parts: str, main: str | None = None) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    attribute = f' main_tree_to_execute="{main}"' if main else ""
    path.write_text(f'<root BTCPP_format="4"{attribute}>{"".join(parts)}</root>', encoding="utf-8")
    return path


def include(path: str, package: str | None = None) -> str:
    return f'<include path="{path}"/>' if package is None else f'<include ros_pkg="{package}" path="{path}"/>'


def tree(name: str, content: str = "<Look/>") -> str:
    return f'<BehaviorTree ID="{name}">{content}</BehaviorTree>'


def uses(name: str) -> str:
    return f'<SubTree ID="{name}"/>'


def messages(path: Path) -> list[str]:
    return [problem.message for problem in check_file(path, registry())]


def test_paths_are_relative_to_the_file_that_includes(tmp_path: Path) -> None:
    main = write(tmp_path / "main.xml", include("parts/a.xml"), tree("Main", uses("A")), main="Main")
    write(tmp_path / "parts/a.xml", include("deep/b.xml"), tree("A", uses("B")))
    write(tmp_path / "parts/deep/b.xml", include("../../c.xml"), tree("B", uses("C")))
    write(tmp_path / "c.xml", tree("C"))
    mission = load_mission(main, registry())
    assert [str(path.relative_to(tmp_path)) for path in mission.files] == [
        "main.xml",
        "parts/a.xml",
        "parts/deep/b.xml",
        "c.xml",
    ]
    assert [node.name for node in mission.root.iterate()] == ["Look", "C", "B", "A"]


def test_a_file_included_twice_is_read_once(tmp_path: Path) -> None:
    main = write(
        tmp_path / "main.xml", include("a.xml"), include("b.xml"), tree("Main", uses("A")), main="Main"
    )
    write(tmp_path / "a.xml", include("c.xml"), tree("A", uses("C")))
    write(tmp_path / "b.xml", include("./c.xml"), tree("B", uses("C")))
    write(tmp_path / "c.xml", tree("C"))
    assert len(load_mission(main, registry()).files) == 4


def test_problems_are_told_with_the_path_from_where_one_stands(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(tmp_path / "trees/main.xml", include("parts/a.xml"), tree("Main", uses("A")), main="Main")
    write(tmp_path / "trees/parts/a.xml", tree("A", "<Lok/>"))
    monkeypatch.chdir(tmp_path)
    (problem,) = check_file("trees/main.xml", registry())
    assert str(problem).startswith("trees/parts/a.xml:1:45: error: unknown node Lok")


def test_a_link_out_of_the_folder_is_outside(tmp_path: Path) -> None:
    secret = write(tmp_path / "outside/secret.xml", tree("Secret"))
    (tmp_path / "inside").mkdir()
    (tmp_path / "inside/link.xml").symlink_to(secret)
    main = write(tmp_path / "inside/main.xml", include("link.xml"), tree("Main", uses("Secret")), main="Main")
    assert messages(main) == ['path is "link.xml"; it leads out of the mission\'s folder, and may not']


def test_a_mission_that_is_a_link_itself_lives_where_the_link_points(tmp_path: Path) -> None:
    write(tmp_path / "source/a.xml", tree("A"))
    main = write(tmp_path / "source/main.xml", include("a.xml"), tree("Main", uses("A")), main="Main")
    link = tmp_path / "install/main.xml"
    link.parent.mkdir()
    link.symlink_to(main)
    assert load_mission(link, registry()).path == main.resolve()


def test_what_is_not_a_file_cannot_be_included(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.xml")
    (tmp_path / "folder.xml").mkdir()
    (tmp_path / "loop.xml").symlink_to(tmp_path / "loop.xml")
    names = ("pipe.xml", "folder.xml", "loop.xml", "x" * 300)
    main = write(tmp_path / "main.xml", *map(include, names), tree("Main"), main="Main")
    found = messages(main)
    assert len(found) == 4
    assert all("there is no file" in message for message in found)


def test_there_is_a_most_of_files(tmp_path: Path) -> None:
    for number in range(MAX_FILES + 3):
        write(tmp_path / f"{number}.xml", tree(f"T{number}"))
    every = [include(f"{number}.xml") for number in range(MAX_FILES + 3)]
    main = write(tmp_path / "main.xml", *every, tree("Main"), main="Main")
    with pytest.raises(MissionError, match=f"more than {MAX_FILES} files in one mission"):
        load_mission(main, registry())


@pytest.fixture
def packages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An ament index that knows one package, `found`; its share folder is returned."""
    share = tmp_path / "share/found"

    def get_package_share_directory(name: str) -> str:
        if name != "found":
            raise LookupError(f"package '{name}' not found")
        return str(share)

    module = types.ModuleType("ament_index_python.packages")
    module.get_package_share_directory = get_package_share_directory
    monkeypatch.setitem(sys.modules, "ament_index_python", types.ModuleType("ament_index_python"))
    monkeypatch.setitem(sys.modules, "ament_index_python.packages", module)
    return share


def test_ros_pkg_is_the_packages_share_folder(tmp_path: Path, packages: Path) -> None:
    write(packages / "trees/a.xml", include("../b.xml"), tree("A", uses("B")))
    write(packages / "b.xml", tree("B"))
    main = write(
        tmp_path / "m/main.xml", include("trees/a.xml", "found"), tree("Main", uses("A")), main="Main"
    )
    assert len(load_mission(main, registry()).files) == 3


def test_a_package_is_not_to_be_left_either(tmp_path: Path, packages: Path) -> None:
    write(packages.parent / "other.xml", tree("A"))
    packages.mkdir(parents=True, exist_ok=True)
    main = write(tmp_path / "m/main.xml", include("../other.xml", "found"), tree("Main"), main="Main")
    assert messages(main) == [
        'path is "../other.xml"; it leads out of the share folder of found, and may not'
    ]


def test_an_unknown_package_is_told(tmp_path: Path, packages: Path) -> None:
    main = write(tmp_path / "main.xml", include("a.xml", "lost"), tree("Main"), main="Main")
    assert messages(main) == ["ros_pkg is \"lost\"; package 'lost' not found; is its workspace sourced?"]


def test_without_ros_a_package_cannot_be_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ament_index_python.packages", None)
    main = write(tmp_path / "main.xml", include("a.xml", "found"), tree("Main"), main="Main")
    assert messages(main) == [
        'ros_pkg is "found", but there is no ROS 2 here (ament_index_python); use a relative path'
    ]
