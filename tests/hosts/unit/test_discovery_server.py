"""Where Fast DDS's discovery server is, and its libraries."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from launcher.hosts import discovery_server


def program(prefix: Path) -> Path:
    path = prefix / "bin" / discovery_server.PROGRAM
    path.parent.mkdir(parents=True)
    path.touch(mode=0o755)
    return path


def test_that_of_the_interpreter_comes_first(tmp_path: Path):
    own, sourced = program(tmp_path / "venv"), program(tmp_path / "ros")
    environ = {"PATH": str(sourced.parent)}
    assert discovery_server.find(environ, str(tmp_path / "venv")) == str(own)
    assert discovery_server.find(environ, str(tmp_path / "other")) == str(sourced)


def test_that_of_a_sourced_ros_is_found_by_its_prefix(tmp_path: Path):
    sourced = program(tmp_path / "ros")
    environ = {"AMENT_PREFIX_PATH": f"{tmp_path}/workspace:{tmp_path}/ros"}
    assert discovery_server.find(environ, "/nowhere") == str(sourced)


def test_the_libraries_of_the_wheels_are_added_once(tmp_path: Path):
    binary = program(tmp_path)
    extra = tmp_path / "lib/python3.11/site-packages/ros_fastrtps.libs"
    extra.mkdir(parents=True)
    environ = {"LD_LIBRARY_PATH": f"{tmp_path}/lib:/else", "HOME": "/root"}
    found = discovery_server.environment(environ, str(binary))
    assert found["LD_LIBRARY_PATH"].split(os.pathsep) == [f"{tmp_path}/lib", str(extra), "/else"]
    assert found["HOME"] == "/root"


@pytest.mark.parametrize(
    ("library", "front"),
    [("libfastrtps.so.2.14", []), ("x86_64-linux-gnu/libfastdds.so.3", ["42"])],
)
def test_fast_dds_3_is_given_the_number_of_its_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, library: str, front: list[str]
):
    binary = program(tmp_path)
    (tmp_path / "lib" / library).parent.mkdir(parents=True)
    (tmp_path / "lib" / library).touch()
    run: list[list[str]] = []
    monkeypatch.setattr(discovery_server, "find", lambda environ, prefix: str(binary))
    monkeypatch.setattr(os, "execve", lambda path, words, environ: run.append(words))

    discovery_server.main(["0", "127.0.0.1", "11811"])
    server = ["-x", discovery_server.PROFILE, "-i", "0", "-l", "127.0.0.1", "-p", "11811"]
    assert run == [[str(binary), *front, *server]]
    assert os.path.isfile(discovery_server.PROFILE)


def test_without_a_server_the_message_says_where_it_comes_from(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setattr(discovery_server, "find", lambda environ, prefix: None)
    with pytest.raises(SystemExit) as error:
        discovery_server.main(["0", "127.0.0.1", "11811"])
    assert error.value.code == 127
    assert f"pip install {discovery_server.wheel()}" in capsys.readouterr().err
