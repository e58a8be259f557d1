"""Text files of users: what has no end is refused, and pipes are read."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from launcher.bag import metadata
from launcher.bag.converting import output_options
from launcher.bag.ros.bag_qos import read_overrides
from launcher.base import text_file, yaml_bounds
from launcher.base.errors import LauncherError, LaunchFileError
from launcher.hosts.file import hosts_reader as hosts
from launcher.language import frontends
from launcher.language.compat import vocabulary
from launcher.language.frontends.parser import read_text
from launcher.language.sources import load_python_launch_file_as_module
from launcher.launch.supervise import supervise_reader as supervision
from launcher.packages.source_packages import has_interfaces
from launcher.ros import parameter_documents, parameter_values
from launcher.ros.snapshot import diff
from launcher.smoke.preflight import loader
from launcher.smoke.reports import measures
from launcher.workspace.building.sources.source_text import PackageText

READERS: dict[str, Callable[[str], object]] = {
    "supervision": supervision.read,
    "hosts": lambda path: hosts.read(path, {}),
    "expectations": loader.load,
    "baseline": lambda path: measures.read(Path(path)),
    "QoS": read_overrides,
    "graph": diff.load,
    "bags": output_options.read,
    "parameters": lambda path: parameter_documents.file_values(path, "/n", use_wildcard=True),
    "launch file": read_text,
    "script": load_python_launch_file_as_module,
}


@pytest.fixture
def huge(tmp_path: Path) -> str:
    path = tmp_path / "huge.yaml"
    path.touch()
    os.truncate(path, 6 << 30)
    return str(path)


@pytest.mark.parametrize("reader", READERS)
def test_a_file_of_gigabytes_is_refused(huge: str, reader: str):
    with pytest.raises((LauncherError, OSError)) as raised:
        READERS[reader](huge)
    error = raised.value
    text = f"{error.where} {error.message}" if isinstance(error, LauncherError) else str(error)
    assert f"it has more than {256 if reader == 'graph' else 16} MiB" in text
    assert huge in text


def test_a_file_without_an_end_is_refused():
    with pytest.raises(OSError, match=r"it has more than 16 MiB: '/dev/zero'"):
        text_file.read("/dev/zero")


def test_the_largest_file_is_read(tmp_path: Path):
    path = tmp_path / "large"
    path.write_bytes(b"x" * text_file.MAX_BYTES)
    assert len(text_file.read(path)) == text_file.MAX_BYTES == yaml_bounds.MAX_CHARACTERS
    path.write_bytes(b"x" * (text_file.MAX_BYTES + 1))
    with pytest.raises(OSError, match="it has more than 16 MiB"):
        text_file.read(path)


def test_a_manifest_and_metadata_of_gigabytes(huge: str, tmp_path: Path):
    for name in ("package.xml", metadata.FILE):
        (tmp_path / name).symlink_to(huge)
    assert not has_interfaces(str(tmp_path))
    with pytest.raises(LauncherError, match="it has more than 16 MiB"):
        metadata.read(str(tmp_path))
    with pytest.raises(LauncherError, match="it has more than 16 MiB"):
        PackageText(str(tmp_path / "package.xml"))


def test_a_pipe_is_read_once(tmp_path: Path):
    path = tmp_path / "pipe"
    os.mkfifo(path)
    text = "n: {ros__parameters: {a: 1}}"
    writer = threading.Thread(target=path.write_text, args=(text,), daemon=True)
    writer.start()
    (given,) = parameter_documents.file_values(str(path), "/n", use_wildcard=True).values()
    assert given == parameter_values.Written(1, "1")


def test_lines_end_in_one_way(tmp_path: Path):
    path = tmp_path / "lines"
    path.write_bytes(b"a\r\nb\rc\n")
    assert text_file.read(path) == path.read_text(encoding="utf-8") == "a\nb\nc\n"


@pytest.mark.parametrize("suffix", ["py", "yaml", "xml"])
def test_a_launch_file_of_gigabytes(huge: str, suffix: str):
    path = f"{huge.removesuffix('.yaml')}.launch.{suffix}"
    os.rename(huge, path)
    with vocabulary([path]), pytest.raises(LaunchFileError) as raised:
        frontends.load(path)
    assert "it has more than 16 MiB" in raised.value.message
