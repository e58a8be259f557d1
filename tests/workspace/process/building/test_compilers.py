"""The compilers of a build, with real programs."""

from __future__ import annotations

import os
import shlex
import subprocess
import sysconfig
from pathlib import Path

import pytest

from launcher.workspace.building.toolchain import compiler


def test_ziglang_finds_what_the_python_h_of_debian_includes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """Its pyconfig.h includes one of another folder, which is of no use to ziglang as a whole."""
    headers, tools = tmp_path / "usr include/python3.99", tmp_path / "tools ü"
    there = headers.parent / "x86_64-linux-gnu/python3.99"
    for folder in (headers, there):
        folder.mkdir(parents=True)
    (headers / "Python.h").write_text("#include <x86_64-linux-gnu/python3.99/pyconfig.h>\n")
    (there / "pyconfig.h").write_text("#define ANSWER 42\n")
    (headers.parent / "x86_64-linux-gnu/other.h").write_text("")
    source = tmp_path / "try.c"
    source.write_text(
        "#include <Python.h>\n"
        "#if __has_include(<x86_64-linux-gnu/other.h>)\n#error other files are visible\n#endif\n"
        "int answer(void) { return ANSWER; }\n"
    )
    monkeypatch.setattr(sysconfig, "get_path", lambda name: str(headers))
    monkeypatch.setattr(sysconfig, "get_config_var", lambda name: "x86_64-linux-gnu")
    for _ in range(2):  # the second time everything is there already
        zig = compiler.choose("zig", os.environ, str(tools))
    command = [*shlex.split(zig.cc), "-c", f"-I{headers}", str(source), "-o", f"{tmp_path}/try.o"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
