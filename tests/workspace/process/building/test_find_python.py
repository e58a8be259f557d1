"""How often CMake asks the interpreter about itself."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from launcher.workspace.building.toolchain.build_variables import HOOK

PYTHON = """#!/bin/sh
echo "$@" >> {log}
exec {python} "$@"
"""
LISTS = """cmake_minimum_required(VERSION 3.20)
project(asks NONE)
find_package(Python3 REQUIRED COMPONENTS Interpreter)
file(STRINGS {log} first)
find_package(Python3 REQUIRED COMPONENTS Interpreter)
find_package(Python3 COMPONENTS Interpreter)
file(STRINGS {log} again)
if(NOT first STREQUAL again OR NOT Python3_FOUND)
  message(FATAL_ERROR "asked again")
endif()
find_package(Python3 3.99 COMPONENTS Interpreter)
if(Python3_FOUND)
  message(FATAL_ERROR "of any version")
endif()
function(apart)
  unset(Python3_EXECUTABLE CACHE)
  set(Python3_EXECUTABLE {other})
  find_package(Python3 REQUIRED COMPONENTS Interpreter)
  if(NOT Python3_EXECUTABLE STREQUAL "{other}")
    message(FATAL_ERROR "another one: ${{Python3_EXECUTABLE}}")
  endif()
endfunction()
apart()
"""


def test_cmake_asks_once_for_the_same(tmp_path: Path):
    log, scripts = tmp_path / "log", [tmp_path / "python3", tmp_path / "other"]
    for script in scripts:
        script.write_text(PYTHON.format(log=log, python=sys.executable))
        script.chmod(0o755)
    (tmp_path / "CMakeLists.txt").write_text(LISTS.format(log=log, other=scripts[1]))
    subprocess.run(
        [
            Path(sys.executable).with_name("cmake"),
            "-S",
            tmp_path,
            "-B",
            tmp_path / "build",
            f"-DCMAKE_PROJECT_INCLUDE={HOOK}",
            f"-DPython3_EXECUTABLE={scripts[0]}",
            "-DLAUNCHER_CPP=ON",
        ],
        check=True,
    )
