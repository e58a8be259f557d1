"""What a package was built from."""

from __future__ import annotations

from pathlib import Path

from launcher.workspace.building import records, sources
from launcher.workspace.building.build_place import Place
from tests.workspace.unit.building.source_tree import interface_package, write


def changes_after(package: sources.Package, root: Path, edit: Path) -> list[str]:
    """What is new to a record when this file gets another line."""
    place = Place(str(root), str(root / "src"))
    setting = records.BuildSetting(place, links=True, tools="", compiler="", options=())
    last = {**records.make(package, setting, {}, None), "installed": []}
    edit.write_text(f"{edit.read_text()}# edited\n")
    return records.changes(last, records.make(package, setting, {}, last), place)


def test_a_file_in_a_linked_folder_counts_and_a_link_to_the_workspace_does_not(tmp_path: Path):
    folder = write(tmp_path / "src", interface_package("p", {})) / "p"
    write(tmp_path, {"common/A.msg": "int8 a\n", "build/p/B.msg": "int8 b\n"})
    (folder / "msg").symlink_to(tmp_path / "common")
    (folder / "msg/again").symlink_to(tmp_path / "common")
    (folder / "workspace").symlink_to(tmp_path)
    (package,) = sources.find([str(tmp_path / "src")]).packages

    assert changes_after(package, tmp_path, tmp_path / "common/A.msg") == ["msg/A.msg changed"]
    assert changes_after(package, tmp_path, tmp_path / "build/p/B.msg") == []
