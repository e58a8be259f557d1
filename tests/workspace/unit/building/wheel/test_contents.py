"""Which installed files become part of a wheel, from folders as colcon leaves them."""

from __future__ import annotations

import os
import zipfile

import pytest

from launcher.base.errors import LauncherError
from launcher.workspace.building import build_place, sources
from launcher.workspace.building.wheel import contents, maker, python_package
from tests.workspace.unit.building import source_tree
from tests.workspace.unit.building.source_tree import INTERFACE_TAGS, manifest

FILES = {
    "lib/libp.so": "",
    "lib/p/tool": "#!/bin/sh\n",
    "lib/python3.11/site-packages/p/__init__.py": "",
    "lib/python3.11/site-packages/p/__pycache__/x.pyc": "",
    "lib/python3.11/site-packages/p/_p.c": "",
    "lib/python3.11/site-packages/p-0.1.0-py3.11.egg-info/PKG-INFO": "Name: p\n",
    "lib/python3.11/site-packages/p-0.1.0-py3.11.egg-info/entry_points.txt": "[console_scripts]\n",
    "include/p/p/msg/detail/m__functions.c": "",
    "share/ament_index/resource_index/packages/p": "",
    "share/ament_index/resource_index/parent_prefix_path/p": "/somewhere",
    "share/p/local_setup.sh": "",
    "share/p/environment/path.dsv": "",
    "share/p/environment/my_plugins.dsv": "",
    "share/p/launch/a b.launch.py": "",
}


@pytest.fixture(params=["isolated", "merged"])
def workspace(tmp_path, request):
    root = tmp_path / "größer und"
    source = root / "src/p"
    source.mkdir(parents=True)
    (source / "package.xml").write_text(manifest("p", *INTERFACE_TAGS))
    (source / "CMakeLists.txt").write_text("project(p)\n")
    prefix = root / "install" if request.param == "merged" else root / "install/p"
    (root / "build/p").mkdir(parents=True)
    for name, text in FILES.items():
        (prefix / name).parent.mkdir(parents=True, exist_ok=True)
        (prefix / name).write_text(text)
    os.chmod(prefix / "lib/p/tool", 0o755)
    (prefix / "share/p/of_an_older_build").touch()
    (root / "install/.colcon_install_layout").write_text(request.param)
    listed = [f"{prefix}/{name}" for name in FILES]
    (root / "build/p/install_manifest.txt").write_text("\n".join(listed[::2]))
    (root / "build/p/symlink_install_manifest.txt").write_text("\n".join(listed[1::2]))
    return root


def found(root):
    where = build_place.find([str(root)])
    return contents.installed(where, sources.read(str(root / "src/p")))


def test_what_is_installed(workspace):
    wheel = found(workspace)
    assert [entry.name for entry in wheel.modules] == ["p/__init__.py"]
    assert [(entry.name, entry.is_executable) for entry in wheel.data] == [
        ("lib/libp.so", False),
        ("lib/p/tool", True),
        ("share/ament_index/resource_index/packages/p", False),
        ("share/p/launch/a b.launch.py", False),
    ]
    assert wheel.entry_points == "[console_scripts]\n"
    assert wheel.left_out == ("share/p/environment/my_plugins.dsv",)


def test_an_incomplete_build(workspace):
    next(workspace.glob("install/**/tool")).unlink()
    with pytest.raises(LauncherError, match=r"p: .*/lib/p/tool is missing"):
        found(workspace)


def test_a_removed_build_folder(workspace):
    for path in (workspace / "build/p").iterdir():
        path.unlink()
    with pytest.raises(LauncherError, match="does not list what is installed"):
        found(workspace)


def test_a_moved_workspace(workspace):
    moved = workspace.rename(workspace.parent / "moved")
    with pytest.raises(LauncherError, match="the workspace was moved after the build"):
        found(moved)


def test_a_package_that_cannot_be_read_is_an_error_unless_others_are_named(workspace):
    text = manifest("q").replace("0.1.0", "first")
    source_tree.write(workspace / "src", {"q/package.xml": text})
    where = build_place.find([str(workspace)])
    with pytest.raises(LauncherError, match="version"):
        maker.selected(where, [], {}, alone=True)
    assert [one.name for one in maker.selected(where, ["p"], {}, alone=True)[0]] == ["p"]


def test_a_source_that_cannot_be_copied_is_named(tmp_path):
    folder = source_tree.write(tmp_path, source_tree.python_package("q")) / "q"
    os.mkfifo(folder / "pipe")
    with pytest.raises(LauncherError, match="named pipe") as caught:
        python_package.contents(sources.read(str(folder)))
    assert str(caught.value.where).endswith("q/pipe")


def test_folders_of_this_machine_are_a_warning(workspace, tmp_path):
    script = next(workspace.glob("install/**/tool"))
    script.write_text(f"exec {workspace}/program\n")
    where = build_place.find([str(workspace)])
    chosen, packages = maker.selected(where, ["p"], {}, alone=True)
    (wheel,) = maker.make(where, chosen, packages, str(tmp_path / "dist"), {})
    assert any("named in p-0.1.0.data/data/lib/p/tool" in text for text in wheel.warnings)
    assert any("environment hooks" in text for text in wheel.warnings)
    with zipfile.ZipFile(wheel.path) as archive:
        assert "p-0.1.0.data/data/lib/p/tool" in archive.namelist()
