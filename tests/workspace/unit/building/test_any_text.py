"""Whatever is in the files of a package, an error has a sentence: no other exception."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from launcher.workspace.building import checks, sources
from launcher.workspace.building.checks.interface_files import InterfaceFile
from launcher.workspace.building.explain import BuildOutput, explain
from launcher.workspace.building.sources import manifest
from launcher.workspace.building.sources.cmake_file import CMakeFile
from launcher.workspace.building.sources.setup_file import SetupFile
from launcher.workspace.building.sources.source_text import SourceError
from tests.workspace.unit.building import source_tree
from tests.workspace.unit.building.source_tree import interface_package, python_package, write

WORDS = st.sampled_from(
    re.findall(
        r"[^ ]+",
        "int32 a [ ] <= 3 = \" ' # --- \n \t ( ) ${ } ${A} foreach endforeach if endif set list "
        "APPEND project find_package REQUIRED rosidl_generate_interfaces DEPENDENCIES string<= "
        "std_msgs/Header Foo / // < > <package <name> </name> & ; : , é 🙂 \x00 \r\n \x1b "
        "module struct { }; enum setup( ) name= data_files= [( )] lambda: import def "
        "CMake Error at a.cpp:1:2: error: fatal Traceback File line",
    )
)
TEXTS = st.lists(WORDS | st.text(max_size=4), max_size=40).map(" ".join) | st.text(max_size=80)
FAST = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)

READERS: dict[str, Callable[[str], object]] = {
    "package.xml": lambda path: manifest.read(path, {}),
    "CMakeLists.txt": CMakeFile,
    "setup.py": SetupFile,
    "A.msg": lambda path: InterfaceFile("p", path),
    "A.srv": lambda path: InterfaceFile("p", path),
    "A.action": lambda path: InterfaceFile("p", path),
    "A.idl": lambda path: InterfaceFile("p", path),
}


@pytest.mark.parametrize("name", READERS)
@FAST
@given(text=TEXTS)
@example(text="")
@example(text="\ufeffint32 a\r\n")
@example(text="foreach(")
@example(text="foreach()\nendforeach()")
@example(text="if(")
@example(text="int32 a=")
@example(text='"')
@example(text="]")
@example(text="a]")
@example(text="[[")
def test_any_text(name: str, text: str, tmp_path: Path):
    path = tmp_path / name
    path.write_bytes(text.encode("utf-8", errors="surrogatepass"))

    with contextlib.suppress(SourceError):
        READERS[name](str(path))


@FAST
@given(text=TEXTS)
def test_any_output(text: str, tmp_path: Path):
    error = explain(BuildOutput("p", str(tmp_path), str(tmp_path / "build"), text))

    assert error is None or error.render()


@pytest.mark.parametrize("name", ["package.xml", "CMakeLists.txt", "setup.py", "A.msg"])
@pytest.mark.parametrize("what", ["latin-1", "a folder", "a dangling link", "null bytes"])
def test_files_that_cannot_be_read(name: str, what: str, tmp_path: Path):
    path = tmp_path / name
    match what:
        case "latin-1":
            path.write_bytes("# größe\n".encode("latin-1"))
        case "a folder":
            path.mkdir()
        case "a dangling link":
            path.symlink_to(tmp_path / "nothing")
        case "null bytes":
            path.write_bytes(b"\0\0")

    with contextlib.suppress(SourceError):
        read = READERS[name](str(path))
        assert what == "null bytes" or (name, what) == ("CMakeLists.txt", "latin-1")
        assert not isinstance(read, InterfaceFile) or read.problems


def test_a_workspace_of_odd_files(tmp_path: Path):
    """Each package has its error, and all others are checked."""
    write(tmp_path, interface_package("good", {"msg/A.msg": "int32 a\r\nint32 b\r\n"}))
    write(tmp_path, interface_package("größe und mehr", {"msg/A.msg": "int32 a\n"}))
    write(tmp_path, python_package("nul", setup_py="\0"))
    for name, encoding in (("codec", "klingon"), ("wide", "big5")):
        declaration = f'<?xml version="1.0" encoding="{encoding}"?>'
        text = source_tree.manifest(name).replace('<?xml version="1.0"?>', declaration)
        write(tmp_path, {f"{name}/package.xml": text})
    write(tmp_path, python_package("cut", setup_py="from setuptools import setup\nsetup("))
    (tmp_path / "latin").mkdir()
    (tmp_path / "latin" / "package.xml").write_bytes("<package>ä</package>".encode("latin-1"))
    (tmp_path / "folder" / "package.xml").mkdir(parents=True)
    (tmp_path / "link").mkdir()
    (tmp_path / "link" / "package.xml").symlink_to("/nothing")
    write(tmp_path, {"deep/package.xml": "<a>" * 100})
    write(tmp_path, {"bom/package.xml": "\ufeff" + source_tree.manifest("bom")})
    write(tmp_path, {"bom/CMakeLists.txt": "\ufeffproject(bom)\r\ninclude(x)\r\n"})

    problems = checks.check(sources.find([str(tmp_path)]))

    places = {
        Path((one.where or "").split(":")[0]).relative_to(tmp_path).parts[0] for one in problems
    }
    # As for colcon, `folder` is not a package.
    assert places == {"größe und mehr", "nul", "codec", "wide", "cut", "latin", "link", "deep"}
