"""A pointer of Git LFS is called that, wherever a file of a repository is read."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from launcher.bag.converting import output_options
from launcher.bag.ros.bag_qos import read_overrides
from launcher.base import text_file
from launcher.base.document.document_reader import text_of
from launcher.base.errors import LauncherError
from launcher.cli.dispatch import main
from launcher.language.context import LaunchContext
from launcher.language.substitution import SubstitutionFailure
from launcher.language.substitutions.files import FileContent
from launcher.ros.parameter_documents import file_values

POINTER = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n"
SENTENCE = "is a pointer of Git LFS in place of the file"


@pytest.fixture
def pointer(tmp_path: Path) -> Path:
    path = tmp_path / "x.yaml"
    path.write_text(POINTER)
    return path


@pytest.mark.parametrize("name", ["x.launch.xml", "x.launch.yaml", "x.launch.py"])
def test_launch_files(tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str):
    (tmp_path / name).write_text(POINTER)
    assert main(["plan", str(tmp_path / name)]) == 2
    told = capsys.readouterr().err
    assert SENTENCE in told
    assert "git lfs pull" in told


@pytest.mark.parametrize(
    "read",
    [
        lambda path: text_of(path, "the hosts"),
        read_overrides,
        output_options.read,
        lambda path: file_values(path, "/n", use_wildcard=True),
    ],
)
def test_files_of_options(pointer: Path, read: Callable[[str], object]):
    with pytest.raises(LauncherError) as caught:
        read(str(pointer))
    assert SENTENCE in caught.value.message
    assert caught.value.hint == text_file.POINTER_HINT


def test_the_content_of_a_file(pointer: Path):
    with pytest.raises(SubstitutionFailure, match=SENTENCE):
        FileContent(str(pointer)).perform(LaunchContext())


def test_a_parameter_file_is_a_warning(
    pointer: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    launch_file = tmp_path / "x.launch.xml"
    node = f'<node pkg="group_gp1" exec="robot_1"><param from="{pointer}"/></node>'
    launch_file.write_text(f"<launch>{node}</launch>")
    assert main(["plan", str(launch_file)]) == 0
    assert f"the parameter file {pointer} {SENTENCE}" in capsys.readouterr().out


@pytest.mark.parametrize("text", ["", "version https://git-lfs", "version: 1", POINTER[1:]])
def test_other_files_are_none(text: str):
    assert not text_file.is_pointer(text)
    assert not text_file.is_pointer(text.encode())
