"""Which detector is started: the choice, the way back to the Python one, and the model's check sum."""

from __future__ import annotations

import hashlib
import sys
from pathlib import Path

import pytest

from target_nav.app.detector_program import BUILD, detector_command
from target_nav.app.model_file import MODELS, check_sum
from target_nav.config import Config
from target_nav.errors import ConfigError

OPTIONS = ("--config", "c.yaml")


def config(**values: object) -> Config:
    return Config().override({f"detector.{key}": value for key, value in values.items()})


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A checkout in which the program is built and the model is there."""
    monkeypatch.setenv("PATH", "/nowhere")
    for path in (BUILD, MODELS["cpu"]):
        (tmp_path / path).parent.mkdir(parents=True)
        (tmp_path / path).write_bytes(b"content")
    (tmp_path / BUILD).chmod(0o755)
    return tmp_path


def option(argv: tuple[str, ...], name: str) -> str:
    return argv[argv.index(name) + 1]


def test_auto_takes_the_network_where_there_is_one(checkout: Path) -> None:
    chosen = detector_command(Config(), "/dev/video0", OPTIONS, root=checkout)
    assert chosen.cpp
    assert chosen.argv[0] == str(checkout / BUILD)
    assert option(chosen.argv, "--model") == str(checkout / MODELS["cpu"])
    assert option(chosen.argv, "--source") == "/dev/video0"
    assert option(chosen.argv, "--prefix") == "v2n"
    assert (option(chosen.argv, "--width"), option(chosen.argv, "--height")) == ("640", "480")
    assert option(chosen.argv, "--class") == "bowling_pin"


@pytest.mark.parametrize(("gone", "told"), [(BUILD, "libopencv-dev"), (MODELS["cpu"], "bowling_pin.onnx")])
def test_auto_falls_back_to_the_python_detector_and_says_why(checkout: Path, gone: Path, told: str) -> None:
    (checkout / gone).unlink()
    chosen = detector_command(Config(), "sim", OPTIONS, root=checkout)
    assert not chosen.cpp
    assert chosen.argv == (sys.executable, "-m", "target_nav.app.detector_node", "--source", "sim", *OPTIONS)
    assert told in chosen.description
    with pytest.raises(ConfigError, match=told):
        detector_command(config(program="cpp"), "sim", OPTIONS, root=checkout)


def test_the_python_detector_can_be_chosen(checkout: Path) -> None:
    assert not detector_command(config(program="python"), "sim", OPTIONS, root=checkout).cpp


def test_another_model_can_be_named(checkout: Path, tmp_path: Path) -> None:
    other = tmp_path / "own.onnx"
    other.write_bytes(b"other")
    chosen = detector_command(config(model=str(other)), "sim", OPTIONS, root=checkout)
    assert option(chosen.argv, "--model") == str(other)
    with pytest.raises(ConfigError, match="not_there"):
        detector_command(config(program="cpp", model="/not_there.onnx"), "sim", OPTIONS, root=checkout)


def test_the_accelerator_takes_a_folder(checkout: Path) -> None:
    (checkout / MODELS["drpai"]).mkdir(parents=True)
    chosen = detector_command(config(backend="drpai"), "0", OPTIONS, root=checkout)
    assert option(chosen.argv, "--backend") == "drpai"
    assert option(chosen.argv, "--model") == str(checkout / MODELS["drpai"])


def test_a_model_with_a_flipped_bit_is_refused(checkout: Path) -> None:
    model = checkout / MODELS["cpu"]
    beside = model.with_name(model.name + ".sha256")
    beside.write_text(f"{hashlib.sha256(b'content').hexdigest()}  {model.name}\n")
    check_sum(model)
    model.write_bytes(b"cOntent")
    with pytest.raises(ConfigError, match="is corrupt: its SHA-256"):
        detector_command(Config(), "sim", OPTIONS, root=checkout)
    beside.write_text("")
    with pytest.raises(ConfigError, match="says nothing"):
        check_sum(model)


@pytest.mark.parametrize("name", ["colour:green", "apriltag:7", "bottle"])
def test_what_the_network_does_not_know_is_the_python_detector_s(checkout: Path, name: str) -> None:
    chosen = detector_command(config(program="cpp"), "sim", OPTIONS, name, checkout)
    assert not chosen.cpp
    assert name in chosen.description
