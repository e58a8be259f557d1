"""Packages of `src/` that are not built, and builds whose source is gone."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from std_srvs.srv import SetBool

from launcher.base.errors import ExecutableNotFoundError, PackageNotFoundError
from launcher.base.ros_errors import VerbError
from launcher.language.diagnostics import import_hints
from launcher.packages import finder, unbuilt
from launcher.packages.source_packages import MARKERS
from launcher.ros.messages import interfaces
from launcher.ros.messages.from_yaml import fill
from launcher.ros.messages.interfaces import (
    load_message,
    note_of_change,
    resolve,
    show,
    warn_if_unknown,
)
from launcher.workspace.building import records, sources
from launcher.workspace.building.build_place import Place
from tests.support.own_package import write_package
from tests.workspace.unit.building.source_tree import interface_package, write


@pytest.fixture(autouse=True)
def ws(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory is a workspace where `bot` needs `more`, and that `bot_msgs`."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr(unbuilt, "_checked", set())
    monkeypatch.setattr(unbuilt, "program", lambda: "launcher")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "prefix"))
    src = tmp_path / "ws/src"
    write_package(src, "bot", depends="<exec_depend>more</exec_depend>")
    write_package(src, "more", depends="<exec_depend>bot_msgs</exec_depend>")
    write(src, interface_package("bot_msgs", {"msg/Word.msg": "string word\n"}))
    monkeypatch.chdir(src.parent)
    return src.parent


def install(ws: Path, package: str) -> Path:
    """Install a package without its files; the link in the index leads to the sources."""
    marker = ws.parent / "prefix" / MARKERS / package
    marker.parent.mkdir(parents=True, exist_ok=True)
    marker.symlink_to(ws / "src" / package / "package.xml")
    return marker


@pytest.mark.parametrize("is_linked", [False, True], ids=["source", "installed as links"])
def test_interfaces_that_are_not_built_are_told_once_before_the_start(ws, capsys, is_linked: bool):
    if is_linked:
        manifest = install(ws, "bot").parents[3] / "bot/package.xml"
        manifest.parent.mkdir()
        manifest.symlink_to(ws / "src/bot/package.xml")
        program = ws.parent / "prefix/lib/bot/bot_talker"
        program.parent.mkdir(parents=True)
        program.touch(0o755)

    for _ in range(2):
        finder.find_executable("bot", "bot_talker", os.environ)

    expected = "warning: bot needs bot_msgs, which is not built\nhint: launcher build\n"
    assert capsys.readouterr().err == expected


def test_nothing_is_told_of_a_package_that_is_only_looked_at(ws: Path, capsys):
    finder.share_directory("bot", os.environ)
    finder.package_prefix("bot", os.environ)
    assert finder.executables("bot", os.environ) == ["bot_talker"]
    with pytest.raises(ExecutableNotFoundError):
        finder.find_executable("bot", "tolker", os.environ)
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("layout", ["isolated", "merged"])
def test_above_the_workspace_that_has_built_them_its_place_is_told(
    ws: Path, monkeypatch, capsys, layout: str
):
    prefix = "install" if layout == "merged" else "install/bot_msgs"
    write(ws, {"install/.colcon_install_layout": layout, f"{prefix}/{MARKERS}/bot_msgs": ""})
    monkeypatch.chdir(ws.parent)
    there = "built in ./ws: cd ws, or --workspace ws"

    finder.find_executable("bot", "bot_talker", os.environ)

    said = "warning: bot needs bot_msgs, which is not found from this folder\n"
    assert capsys.readouterr().err == f"{said}hint: it is {there}\n"
    hint = f"bot_msgs is in {ws}/src/bot_msgs, and {there}"
    assert unbuilt.hint("bot_msgs", os.environ) == hint

    monkeypatch.chdir(ws)
    monkeypatch.setenv("LAUNCHER_WORKSPACE", "")
    assert str(unbuilt.hint("bot_msgs", os.environ)).endswith(f" built in {ws}: --workspace {ws}")


def test_above_the_workspace_the_command_to_build_names_it(ws: Path, monkeypatch, capsys):
    monkeypatch.chdir(ws.parent)

    finder.find_executable("bot", "bot_talker", os.environ)

    expected = "warning: bot needs bot_msgs, which is not built\nhint: launcher build ws\n"
    assert capsys.readouterr().err == expected
    assert str(unbuilt.hint("bot_msgs", os.environ)).endswith(", and not built: launcher build ws")


def test_nothing_is_searched_for_a_package_that_is_in_no_workspace(ws: Path, monkeypatch):
    (ws / "src").rename(ws / "sources")
    monkeypatch.setattr("launcher.packages.source_packages._below", pytest.fail)
    unbuilt.warn_of_dependencies("bot", str(ws / "sources/bot"), os.environ)


def test_nothing_is_told_of_interfaces_that_are_built(ws: Path, capsys):
    install(ws, "bot_msgs")
    finder.find_executable("bot", "bot_talker", os.environ)
    assert capsys.readouterr().err == ""
    assert unbuilt.hint("bot_msgs", os.environ) is None


@pytest.mark.parametrize(
    ("target", "is_told"),
    [("{root}/build/bot_msgs/marker", True), ("{root}-before/build/bot_msgs/marker", False)],
    ids=["build folder is gone", "workspace was moved"],
)
def test_a_moved_workspace_is_not_told_to_be_unbuilt(
    ws: Path, monkeypatch, capsys, target: str, is_told: bool
):
    monkeypatch.setenv("COLCON_PREFIX_PATH", str(ws / "install"))
    marker = ws / "install/bot_msgs" / MARKERS / "bot_msgs"
    marker.parent.mkdir(parents=True)
    marker.symlink_to(target.format(root=ws))

    finder.find_executable("bot", "bot_talker", os.environ)

    assert ("not built" in capsys.readouterr().err) is is_told
    assert (unbuilt.hint("bot_msgs", os.environ) is not None) is is_told


def test_the_nearest_of_two_sources_is_told(ws: Path, monkeypatch):
    write(ws / "below/src", interface_package("bot_msgs", {}))
    monkeypatch.chdir(ws / "below")
    assert f"{ws}/below/src/bot_msgs," in str(unbuilt.hint("bot_msgs", os.environ))


def test_a_type_of_a_package_that_is_not_built_is_no_unknown_one(ws: Path, capsys):
    said = f"bot_msgs is in {ws}/src/bot_msgs, and not built: "
    for ask in (resolve, load_message):
        with pytest.raises(VerbError) as caught:
            ask("bot_msgs/msg/Word")
        assert str(caught.value.hint).startswith(said)
    warn_if_unknown("bot_msgs/msg/Word")
    assert said in capsys.readouterr().err


def test_a_launch_file_that_imports_them_fails_with_the_hint(ws: Path):
    error = ModuleNotFoundError("No module named 'bot_msgs'", name="bot_msgs")
    said = f"bot_msgs is in {ws}/src/bot_msgs, and not built: launcher build"
    assert import_hints.hint(error, str(error)) == said


def install_types(ws: Path, package: str, texts: dict[str, str]) -> Path:
    """Install the definitions of messages; the folder that they are in."""
    share = ws.parent / "prefix/share"
    index = share / "ament_index/resource_index/rosidl_interfaces" / package
    names = "".join(f"msg/{name}.idl\nmsg/{name}.msg\n" for name in texts)
    write(share, {str(index.relative_to(share)): names})
    write(share / package / "msg", {f"{name}.msg": text for name, text in texts.items()})
    return share / package / "msg"


@pytest.mark.parametrize(
    ("field", "message", "is_in_sources"),
    [
        ("bot_msgs/Word", "needs the package 'bot_msgs', which is not installed", True),
        ("gone_msgs/Word[2]", "needs the package 'gone_msgs', which is not installed", False),
        ("Lost", "needs top_msgs/msg/Lost, which is not installed", False),
    ],
)
def test_the_type_of_a_field_that_is_gone_is_told(ws, field: str, message: str, is_in_sources):
    install_types(ws, "top_msgs", {"Top": f"{field} word\n"})

    with pytest.raises(VerbError) as caught:
        list(show("top_msgs/msg/Top", comments=True, nested_comments=False))

    assert caught.value.message == f"top_msgs/msg/Top {message}"
    assert ("not built: " in str(caught.value.hint)) is is_in_sources


def test_a_definition_that_was_edited_after_its_build_is_noted(ws: Path, monkeypatch):
    source = ws / "src/bot_msgs/msg/Word.msg"
    place = Place(str(ws), str(ws / "src"))
    setting = records.BuildSetting(place, links=True, tools="", compiler="", options=())
    package = sources.find([str(ws / "src/bot_msgs")]).packages[0]
    records.store(place, records.make(package, setting, {}, None))
    prefix = ws / "install/bot_msgs"
    index = "share/ament_index/resource_index/rosidl_interfaces/bot_msgs"
    write(prefix, {index: "msg/Word.idl\n", "share/bot_msgs/msg/Word.idl": ""})
    (prefix / "share/bot_msgs/msg/Word.msg").symlink_to(source)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(prefix))

    source.touch()
    assert note_of_change("bot_msgs/msg/Word") is None
    source.write_text("string word\nint8 more\n", encoding="utf-8")
    said = "note: the definition of bot_msgs/msg/Word has changed since the build: "
    assert str(note_of_change("bot_msgs/msg/Word")).startswith(said)
    assert note_of_change("std_msgs/msg/String") is None


def test_an_unknown_field_of_a_changed_definition_has_the_note(monkeypatch):
    monkeypatch.setattr(interfaces, "note_of_change", lambda full: f"note: {full}")
    with pytest.raises(VerbError) as caught:
        fill(SetBool.Request(), {"more": 1})
    hint = "fields of SetBool_Request: data\nnote: std_srvs/srv/SetBool"
    assert caught.value.render().endswith(f"hint: {hint}")


def test_a_definition_whose_source_is_gone_is_told_although_its_idl_is_there(ws: Path):
    folder = install_types(ws, "top_msgs", {"Top": "int8 a\n"})
    source = ws / "src/top_msgs/msg/Top.msg"
    (folder / "Top.msg").unlink()
    (folder / "Top.msg").symlink_to(source)
    (folder / "Top.idl").write_text("module top_msgs { };\n", encoding="utf-8")

    with pytest.raises(VerbError) as caught:
        list(show("top_msgs/msg/Top", comments=True, nested_comments=False))

    assert caught.value.message == f"the source of top_msgs/msg/Top is gone: {source}"
    assert str(caught.value.hint).endswith(" build")


def test_links_to_a_source_that_is_gone_are_told(ws: Path):
    install(ws, "bot")
    (ws / "src/bot").rename(ws / "other")
    (ws / "other/package.xml").unlink()
    with pytest.raises(PackageNotFoundError) as caught:
        finder.find_executable("bot", "bot_talker", os.environ)
    gone = f"it is installed in {ws.parent}/prefix, as links to {ws}/src/bot/package.xml, which is"
    assert str(caught.value.hint).startswith(gone)


def test_a_build_folder_is_no_source(ws: Path, monkeypatch: pytest.MonkeyPatch):
    """colcon puts it into PYTHONPATH, with the egg-info of a package and a link to package.xml."""
    build = write_package(ws / "build", "left")
    info = "Metadata-Version: 2.1\nName: left\nVersion: 0.0.0\n"
    write(build, {"colcon_build.rc": "0\n", "left.egg-info/PKG-INFO": info})
    monkeypatch.syspath_prepend(str(build))
    for folder in (ws, ws / "build", build):
        monkeypatch.chdir(folder)
        with pytest.raises(PackageNotFoundError):
            finder.find_executable("left", "left_talker", os.environ)
