"""What is said about packages with a mistake in setup.py or package.xml."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from launcher.base.errors import (
    ExecutableNotFoundError,
    PackageNotFoundError,
    UsageError,
)
from launcher.language.frontends.locate import locate
from launcher.packages import finder, overlay, source_packages
from tests.support.own_package import write_package


@pytest.fixture(autouse=True)
def work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory, which holds no package; nothing is kept from other tests."""
    (tmp_path / "tmp").mkdir()
    (tmp_path / "work").mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "tmp"))
    monkeypatch.chdir(tmp_path / "work")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "none"))
    return tmp_path / "work"


def test_an_empty_name_is_of_no_package():
    with pytest.raises(PackageNotFoundError):
        finder.share_directory("", os.environ)


BROKEN = {
    "import numpi\n": "ModuleNotFoundError: No module named 'numpi' (line 1)",
    "import os\n\nsetup('bot'\n": "SyntaxError: '(' was never closed (line 3)",
    "import os\n\nif input():\n    pass\n": "EOFError: EOF when reading a line (line 3)",
}


@pytest.mark.parametrize(("text", "problem"), BROKEN.items(), ids=["module", "syntax", "input"])
def test_a_broken_setup_py_is_reported_where_something_is_missing(work: Path, text, problem):
    source = write_package(work, "bot")
    (source / "setup.py").write_text(text)

    file = source / "launch/bot.launch.py"
    assert locate(["bot", "bot.launch.py"], os.environ) == file
    with pytest.raises(ExecutableNotFoundError) as caught:
        finder.find_executable("bot", "talk", os.environ)
    assert caught.value.hint == f"{source}/setup.py could not be read: {problem}"


def test_a_setup_py_that_hangs_is_named_and_waited_for_once(work: Path, monkeypatch, capsys):
    monkeypatch.setattr(overlay, "_READER_TIMEOUT_S", 0.5)
    source = write_package(work, "bot")
    (source / "setup.py").write_text(
        "import signal\nopen('runs', 'a').write('x')\nsignal.pause()\n"
    )
    (source / "runs").touch()

    assert finder.share_directory("bot", os.environ) == source
    said = capsys.readouterr().err
    assert f"warning: {source}/setup.py could not be read: it did not end within 0.5 s\n" in said
    with pytest.raises(ExecutableNotFoundError) as caught:
        finder.find_executable("bot", "talk", os.environ)
    assert caught.value.hint == (
        f"{source}/setup.py could not be read: it did not end within 0.5 s"
    )
    assert capsys.readouterr().err == ""
    assert len((source / "runs").read_text()) <= 1

    monkeypatch.setattr(overlay, "_READER_TIMEOUT_S", 60.0)
    write_package(work, "bot")  # another setup.py is tried again
    assert finder.executables("bot", os.environ) == ["bot_talker"]


MANIFESTS = {
    None: "{folder}/ has no package.xml",
    "": "{folder}/package.xml could not be read: no element found: line 1, column 0",
    "<package>\n<name>bot</nam>": (
        "{folder}/package.xml could not be read: mismatched tag: line 2, column 11"
    ),
    "<package/>": "{folder}/package.xml has no <name>",
}


@pytest.mark.parametrize(("text", "hint"), MANIFESTS.items(), ids=["none", "empty", "tag", "name"])
@pytest.mark.parametrize("place", [".", "ws/src/bot"], ids=["beside", "inside"])
def test_a_source_folder_without_a_readable_package_xml_is_named(
    work: Path, monkeypatch, text: str | None, hint: str, place: str
):
    write_package(work / "ws/src", "bots")
    source = write_package(work / "ws/src", "bot")
    if text is None:
        (source / "package.xml").unlink()
    else:
        (source / "package.xml").write_text(text)
    monkeypatch.chdir(work / place)

    with pytest.raises(PackageNotFoundError) as caught:
        locate(["bot", "bot.launch.py"], os.environ)
    assert caught.value.hint == hint.format(folder=source)


def test_prefixes_of_links_are_no_part_of_the_hint(work: Path):
    write_package(work, "bot")
    prefix = finder.package_prefix("bot", os.environ)
    assert str(prefix) in os.environ["AMENT_PREFIX_PATH"]

    with pytest.raises(PackageNotFoundError) as caught:
        finder.package_prefix("zzz", os.environ)
    assert (caught.value.hint or "").startswith(f"searched: {work.parent}/none, {sys.prefix}, edit")


ONLY_DATA_FILES = "only files that setup.py names in data_files are installed"


@pytest.mark.parametrize(
    ("installed", "hint"),
    [
        ((), f"there is no launch file; {ONLY_DATA_FILES}"),
        (("main.launch.py",), f"available: main.launch.py; {ONLY_DATA_FILES}"),
        (("dem.launch.py",), "did you mean 'dem.launch.py'?"),
    ],
    ids=["none", "another", "near"],
)
def test_a_launch_file_that_was_not_installed_is_explained(
    tmp_path: Path, monkeypatch, installed: tuple[str, ...], hint: str
):
    prefix, site = tmp_path / "prefix", tmp_path / "site"
    for file in (
        prefix / source_packages.MARKERS / "bot",
        site / "bot-1.dist-info/METADATA",
        *(prefix / "share/bot/launch" / name for name in installed),
    ):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("Metadata-Version: 2.1\nName: bot\nVersion: 1\n")
    monkeypatch.syspath_prepend(site)

    with pytest.raises(UsageError, match="was not found in the share directory") as caught:
        locate(["bot", "demo.launch.py"], {"AMENT_PREFIX_PATH": str(prefix)})
    assert caught.value.hint == hint
