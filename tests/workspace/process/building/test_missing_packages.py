"""Built types whose packages or libraries are gone."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from launcher.base.errors import ExitCode
from tests.support.workspaces import launcher
from tests.workspace.process.building.small_packages import built, message_package, write

pytestmark = pytest.mark.thorough


def test_types_that_need_a_package_or_library_that_is_gone(tmp_path: Path):
    message_package(tmp_path / "src", "low")
    top = message_package(tmp_path / "src", "top", "msg/Pair.msg", depends=["low"])
    write(top / "msg/Pair.msg", "low/Number[2] numbers\n")
    built(tmp_path)
    pair = "top/msg/Pair"

    def answers() -> set[tuple[int, str]]:
        verbs = (("pub", "/t", pair, "{}", "--once", "-w", "0"), ("echo", "/t", pair, "--once"))
        found = [launcher(tmp_path, "topic", *words) for words in verbs]
        return {(answer.code, answer.err) for answer in found}

    library = tmp_path / "install/top/lib/libtop__rosidl_typesupport_c.so"
    library.rename(tmp_path / library.name)
    assert answers() == {
        (
            ExitCode.PROCESS_FAILED,
            f"the library of {pair} cannot be loaded: {library.name}: cannot open shared object "
            "file: No such file or directory\n",
        )
    }
    (tmp_path / library.name).rename(library)

    shutil.rmtree(tmp_path / "build/low")
    shutil.rmtree(tmp_path / "install/low")
    message = (
        f"{pair} needs the package 'low', which is not installed\n"
        f"hint: low is in {tmp_path}/src/low, and not built: python -m launcher build\n"
    )
    assert answers() == {(ExitCode.PROCESS_FAILED, message)}
    shown = launcher(tmp_path, "interface", "show", pair)
    assert (shown.code, shown.err) == (ExitCode.PROCESS_FAILED, message)
