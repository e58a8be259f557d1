"""Imports of programs, found without running them."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from launcher.packages.imports import Imports, imports_of, is_installed
from tests.workspace.unit.building.source_tree import write


def found(folder: Path, script: str, **files: str) -> Imports:
    """The imports of a script beside these modules; `__` in their names is a slash."""
    write(folder, {"main.py": script})
    for name, text in files.items():
        write(folder, {f"{name.replace('__', '/')}.py": text})
    return imports_of(str(folder / "main.py"), path=[str(folder), *sys.path])


def names(imports: Imports, folder: Path) -> list[str]:
    return [str(Path(file).relative_to(folder)) for file in imports.files]


def test_the_users_modules_are_followed(tmp_path: Path):
    imports = found(tmp_path, "import one", one="from two import x", two="x = 1")
    assert names(imports, tmp_path) == ["main.py", "one.py", "two.py"]
    assert imports.modules == {"one": f"{tmp_path}/one.py", "two": f"{tmp_path}/two.py"}


def test_relative_imports_and_packages_are_followed(tmp_path: Path):
    write(tmp_path, {"bot/__init__.py": "from . import a", "bot/a.py": "from .sub.b import x"})
    write(tmp_path, {"bot/sub/__init__.py": "", "bot/sub/b.py": "from ... import far\nx = 1"})
    imports = found(tmp_path, "import bot")
    assert sorted(imports.modules) == ["bot", "bot.a", "bot.sub", "bot.sub.b"]


def test_installed_modules_are_named_and_not_followed(tmp_path: Path):
    imports = found(tmp_path, "import rclpy.node\nfrom std_msgs.msg import String\nimport json")
    assert list(imports.installed) == ["rclpy", "rclpy.node", "std_msgs", "std_msgs.msg", "json"]
    assert list(imports.attributes) == [("std_msgs.msg", "String")]
    assert names(imports, tmp_path) == ["main.py"]


def test_attributes_of_modules_are_noted(tmp_path: Path):
    imports = found(tmp_path, "import std_msgs.msg\nx = std_msgs.msg.String()")
    assert ("std_msgs.msg", "String") in imports.attributes


def test_what_only_a_function_imports_is_deferred(tmp_path: Path):
    imports = found(tmp_path, "import one\ndef f():\n    import json, two", one="", two="")
    assert (list(imports.installed), list(imports.deferred)) == ([], ["json"])
    assert names(imports, tmp_path) == ["main.py", "one.py", "two.py"]


def test_what_only_type_checkers_import_is_left_out(tmp_path: Path):
    text = "import typing\nif typing.TYPE_CHECKING:\n    import json\nelse:\n    import csv"
    assert list(found(tmp_path, text).installed) == ["typing", "csv"]


def test_the_package_of_a_module_that_is_run_is_read(tmp_path: Path):
    write(tmp_path, {"bot/__init__.py": "import json", "bot/__main__.py": "from bot import a"})
    write(tmp_path, {"bot/a.py": ""})
    imports = imports_of(module="bot", path=[str(tmp_path), *sys.path])
    assert sorted(imports.modules) == ["bot", "bot.__main__", "bot.a"]


def test_an_entry_point_of_colcon_is_followed(tmp_path: Path):
    write(tmp_path, {"bot/__init__.py": "", "bot/node.py": "import json"})
    write(tmp_path, {"bot-1.0.dist-info/METADATA": "Name: bot\nVersion: 1.0\n"})
    points = "[console_scripts]\ntalker = bot.node:main\n"
    write(tmp_path, {"bot-1.0.dist-info/entry_points.txt": points})
    text = "load_entry_point('bot==1.0', 'console_scripts', 'talker')()"
    assert "bot.node" in found(tmp_path, text).modules


@pytest.mark.parametrize("text", ["def (", "\0", "import no_such", "from . import x"])
def test_a_program_that_fails_has_the_imports_that_are_known(tmp_path: Path, text: str):
    imports = found(tmp_path, text)
    assert names(imports, tmp_path) == ["main.py"]
    assert not imports.modules


def test_modules_that_import_each_other_are_read_once(tmp_path: Path):
    imports = found(tmp_path, "import one", one="import two", two="import one, main")
    assert names(imports, tmp_path) == ["main.py", "one.py", "two.py"]


def test_packages_without_an_init_file_are_followed(tmp_path: Path):
    write(tmp_path, {"space/inner.py": "import json"})
    imports = found(tmp_path, "import space.inner")
    assert list(imports.modules) == ["space.inner"]
    assert list(imports.installed) == ["json"]


def test_what_a_workspace_has_installed_is_the_users(tmp_path: Path):
    assert not is_installed(f"{tmp_path}/install/bot/lib/python3.11/site-packages/bot/a.py")
    assert is_installed(pytest.__file__)


@pytest.mark.parametrize(
    "change",
    [
        "sys.path[0] = {folder!r}",
        "sys.path += [{folder!r}]",
        "sys.path.append({folder!r})",
        "sys.path.insert(0, {folder!r})",
    ],
)
def test_folders_that_a_program_adds_to_its_path_are_searched(tmp_path: Path, change: str):
    write(tmp_path / "code", {"talker.py": "x = 1"})
    added = change.format(folder=str(tmp_path / "code"))
    (tmp_path / "main.py").write_text(f"import sys\n\n{added}\nfrom talker import x\n")
    imports = imports_of(str(tmp_path / "main.py"))
    assert names(imports, tmp_path) == ["main.py", "code/talker.py"]
    assert not imports.missing
