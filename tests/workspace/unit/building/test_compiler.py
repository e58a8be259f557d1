"""Which compiler a build uses; the compilers are real, or broken scripts."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from launcher.base.errors import LauncherError, UsageError
from launcher.workspace.building.toolchain import compiler

GCC = shutil.which("gcc")
pytestmark = pytest.mark.basic  # they start compilers


def program(folder: Path, name: str, script: str) -> None:
    folder.mkdir(exist_ok=True)
    path = folder / name
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(0o755)


def environment(*folders: Path, **variables: str) -> dict[str, str]:
    return {"PATH": os.pathsep.join(map(str, folders)), **variables}


@pytest.mark.skipif(GCC is None, reason="needs gcc")
def test_the_compiler_of_the_system(tmp_path: Path):
    found = compiler.choose("auto", os.environ, str(tmp_path))

    assert found.cc == GCC
    assert f"-DCMAKE_C_COMPILER={GCC}" in found.cmake_args


def test_without_a_compiler_it_is_zig(tmp_path: Path):
    found = compiler.choose("auto", environment(tmp_path), str(tmp_path / "tools"))

    assert found.is_zig
    assert os.access(tmp_path / "tools/c++", os.X_OK)
    assert f"-DCMAKE_AR={tmp_path}/tools/ar" in found.cmake_args


@pytest.mark.skipif(GCC is None, reason="needs gcc")
def test_gcc_without_g_plus_plus_is_no_compiler(tmp_path: Path):
    (tmp_path / "gcc").symlink_to(str(GCC))

    assert compiler.choose("auto", environment(tmp_path), str(tmp_path / "tools")).is_zig
    with pytest.raises(LauncherError, match=r"gcc is there, but no g\+\+"):
        compiler.choose("system", environment(tmp_path), str(tmp_path / "tools"))


def test_a_compiler_that_does_not_compile_is_none(tmp_path: Path):
    for name in ("gcc", "g++"):
        program(tmp_path / "bin", name, "echo 'x.c:1:10: fatal error: stdio.h: no' >&2; exit 1")

    assert compiler.choose("auto", environment(tmp_path / "bin"), str(tmp_path / "tools")).is_zig
    with pytest.raises(LauncherError, match=r"does not compile a small program: stdio\.h: no"):
        compiler.choose("system", environment(tmp_path / "bin"), str(tmp_path / "tools"))


@pytest.mark.skipif(GCC is None, reason="needs gcc")
def test_cc_and_cxx_count_first(tmp_path: Path):
    folder = tmp_path / "a folder"
    program(folder, "my-gcc", f'exec {GCC} "$@"')
    program(folder, "my-g++", f'exec {shutil.which("g++")} "$@"')
    env = {**os.environ, "CC": f"'{folder}/my-gcc' -Wall"}

    found = compiler.choose("auto", env, str(tmp_path))

    assert (found.cc, found.cxx) == (env["CC"], f"'{folder}/my-g++' -Wall")
    assert not any("C_COMPILER" in word for word in found.cmake_args)  # from the variable


@pytest.mark.skipif(GCC is None, reason="needs gcc")
@pytest.mark.parametrize(
    ("wanted", "variables"),
    [("auto", {"CC": "./my-gcc"}), ("auto", {"CXX": "bin/../my-g++"}), ("./my-gcc", {})],
)
def test_a_relative_path_starts_at_the_working_directory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, wanted: str, variables: dict[str, str]
):
    for name in ("gcc", "g++"):
        program(tmp_path, f"my-{name}", f'exec {shutil.which(name)} "$@"')
    monkeypatch.chdir(tmp_path)

    found = compiler.choose(wanted, {**os.environ, **variables}, str(tmp_path))

    assert (found.cc, found.cxx) == (f"{tmp_path}/my-gcc", f"{tmp_path}/my-g++")


@pytest.mark.parametrize(
    ("wanted", "variables", "message", "hint"),
    [
        (
            "auto",
            {"CC": "./nosuch"},
            "CC=./nosuch cannot be started: No such file or directory",
            "correct CC, or unset it",
        ),
        (
            "auto",
            {"CC": "/bin/my-gcc"},
            "/bin/my-g++ cannot be started: No such file or directory",
            "set CXX to the compiler that belongs to that of CC",
        ),
        (
            "false",
            {},
            "/bin/false does not compile a small program: exit code 1",
            "--compiler names a C compiler, such as clang",
        ),
        (
            "my-gcc",
            {},
            "/bin/my-g++ cannot be started: No such file or directory",
            "--compiler my-gcc needs /bin/my-g++ as well; "
            "for another one set CC=my-gcc and CXX, without --compiler",
        ),
        (
            "only-c",
            {},
            "/bin/only-c does not compile a small program: exit code 1",
            "the C++ compiler of only-c is not known: set CC and CXX, without --compiler",
        ),
    ],
)
def test_a_wrong_compiler_is_an_error_and_not_passed_over(
    tmp_path: Path, wanted: str, variables: dict[str, str], message: str, hint: str
):
    folder = tmp_path / "bin"
    program(folder, "false", "exit 1")
    program(folder, "my-gcc", "exit 0")
    program(folder, "only-c", 'case "$*" in *.cpp*) exit 1;; esac')
    env = environment(folder, **{k: v.replace("/bin", str(folder)) for k, v in variables.items()})

    with pytest.raises(LauncherError) as raised:
        compiler.choose(wanted, env, str(tmp_path))

    said = (raised.value.message, raised.value.hint)
    assert said == tuple(text.replace("/bin", str(folder)) for text in (message, hint))


def test_a_cc_with_an_open_quote_is_an_error(tmp_path: Path):
    with pytest.raises(LauncherError, match=r"CC=gcc ': No closing quotation"):
        compiler.choose("auto", {**os.environ, "CC": "gcc '"}, str(tmp_path))


def test_an_unknown_name(tmp_path: Path):
    with pytest.raises(UsageError, match="there is no program 'gc'"):
        compiler.choose("gc", os.environ, str(tmp_path))


@pytest.mark.parametrize("is_absolute", [False, True])
@pytest.mark.parametrize(("name", "what"), [("noexec", "is not executable"), ("bin", "a folder")])
def test_a_path_that_cannot_be_started(tmp_path, monkeypatch, is_absolute, name, what):
    (tmp_path / "noexec").touch()
    (tmp_path / "bin").mkdir()
    monkeypatch.chdir(tmp_path)
    wanted = str(tmp_path / name) if is_absolute else f"./{name}"

    with pytest.raises(UsageError) as raised:
        compiler.choose(wanted, os.environ, str(tmp_path))

    assert raised.value.message.startswith(f"--compiler: '{wanted}' is ")
    assert raised.value.message.endswith(what)


@pytest.mark.skipif(GCC is None, reason="needs gcc")
def test_the_identity_changes_with_the_program(tmp_path: Path):
    for name in ("gcc", "g++"):
        program(tmp_path, name, f'exec {shutil.which(name)} "$@"')
    env = {**os.environ, "CC": str(tmp_path / "gcc")}
    first = compiler.choose("auto", env, str(tmp_path)).identity
    assert compiler.choose("auto", env, str(tmp_path)).identity == first

    program(tmp_path, "g++", f'exec {shutil.which("g++")} -Wall "$@"')

    assert compiler.choose("auto", env, str(tmp_path)).identity != first


def test_each_ziglang_has_a_cache_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """It recognizes its files by inode and time stamp."""
    first, link, second = (tmp_path / name for name in ("first", "link", "second"))
    first.touch()
    link.hardlink_to(first)
    shutil.copy2(first, second)
    caches = []
    for path in (first, link, second):
        monkeypatch.setattr(compiler, "_zig_program", lambda path=path: str(path))
        env = {"ZIG_GLOBAL_CACHE_DIR": str(tmp_path / "cache")}
        variables = compiler.choose("zig", env, str(tmp_path / "tools")).variables
        caches.append(Path(variables["ZIG_GLOBAL_CACHE_DIR"]))
    assert caches[0] == caches[1] != caches[2]
    assert {cache.parent for cache in caches} == {tmp_path / "cache"}


def test_zig_is_the_same_as_long_as_its_scripts_are(tmp_path: Path):
    first = compiler.choose("zig", {}, str(tmp_path)).identity

    assert compiler.choose("zig", {}, str(tmp_path)).identity == first
