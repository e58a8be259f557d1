"""What changes of real files mean for processes, without watching them."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import pytest

from launcher.run.watch import file_checks
from launcher.run.watch.watched import Broken, Changed, Deleted, Report, Watched
from launcher.run.watch.watched_programs import WatchedProgram, files_of

LATER_NS = time.time_ns() + 10**15
MODULE = "X = {}\n"


class Scene:
    """`main.py`, which imports `own.py`, run by processes `a` and `b`; `b` has parameters."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.main, self.own = folder / "main.py", folder / "own.py"
        self.parameters = folder / "parameters.yaml"
        self.main.write_text("import own\n")
        self.own.write_text(MODULE.format(1))
        self.parameters.write_text("/**: {ros__parameters: {x: 1}}\n")
        self.watched = Watched()
        for name in ("a", "b"):
            assert self.start(name) == []

    def start(self, name: str, started_ns: int = LATER_NS) -> list[str]:
        parameters = (str(self.parameters),) if name == "b" else ()
        argv = (sys.executable, str(self.main))
        program = WatchedProgram(argv, {}, str(self.folder), parameters)
        return self.watched.add_process(name, program, started_ns)

    def settle(self) -> list[Report]:
        return self.watched.settled(list(self.watched.look()))


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    return Scene(tmp_path)


def restarts(reports: list[Report]) -> list[str]:
    return [name for one in reports if isinstance(one, Changed) for name, _ in one.processes]


def test_the_files_of_a_program_are_its_own_ones_and_those_that_it_imports(scene: Scene):
    assert scene.watched.files("a") == [str(scene.main), str(scene.own)]
    assert scene.watched.files("b") == [*scene.watched.files("a"), str(scene.parameters)]


def test_a_change_restarts_those_that_have_loaded_the_file(scene: Scene):
    scene.own.write_text(MODULE.format(2))
    assert restarts(scene.settle()) == ["a", "b"]
    assert scene.settle() == []
    scene.parameters.write_text("/**: {ros__parameters: {x: 2}}\n")
    assert restarts(scene.settle()) == ["b"]


def test_the_same_content_is_no_change(scene: Scene):
    scene.own.write_text(MODULE.format(1))
    os.utime(scene.main)
    assert scene.settle() == []


def test_an_error_of_syntax_is_told_once_for_a_content_and_nothing_restarts(scene: Scene):
    scene.own.write_text("X = (\n")
    (broken,) = scene.settle()
    assert isinstance(broken, Broken) and broken.processes == ("a", "b")
    assert broken.error.render().split("\n") == [
        f"error: {scene.own}:1: '(' was never closed",
        "    X = (",
        "        ^",
    ]
    os.utime(scene.own)
    assert scene.settle() == []
    scene.own.write_text("X = )\n")
    assert [type(one) for one in scene.settle()] == [Broken]
    scene.own.write_text("X = (\n")
    assert [type(one) for one in scene.settle()] == [Broken]
    scene.own.write_text(MODULE.format(1))
    assert scene.settle() == []  # as it was loaded
    scene.own.write_text(MODULE.format(2))
    assert restarts(scene.settle()) == ["a", "b"]


def test_one_broken_file_of_several_holds_the_restart_until_it_is_whole(scene: Scene):
    scene.own.write_text("X = (\n")
    scene.main.write_text("import own  # changed\n")
    assert [type(one) for one in scene.settle()] == [Broken]
    scene.own.write_text(MODULE.format(3))
    (changed,) = scene.settle()
    assert isinstance(changed, Changed)
    assert set(changed.paths) == {str(scene.main), str(scene.own)}


def test_a_new_import_is_watched_and_checked_before_the_restart(scene: Scene):
    other = scene.folder / "other.py"
    other.write_text("Y = (\n")
    scene.own.write_text("import other\n")
    assert [type(one) for one in scene.settle()] == [Broken]
    other.write_text("Y = 1\n")
    assert restarts(scene.settle()) == ["a", "b"]
    assert scene.start("a") == []
    assert str(other) in scene.watched.files("a")


def test_a_deleted_file_is_told_and_the_process_runs_on(scene: Scene):
    scene.own.unlink()
    (deleted,) = scene.settle()
    assert deleted == Deleted(str(scene.own), ("a", "b"))
    scene.own.write_text(MODULE.format(1))
    assert scene.settle() == []
    scene.own.unlink()
    scene.main.write_text("X = 1\n")  # nothing imports it any more
    assert restarts(scene.settle()) == ["a", "b"]


@pytest.mark.parametrize(
    "argv",
    [
        (sys.executable, "main.py"),
        (sys.executable, "-u", "main.py"),
        ("nice", "-n", "5", sys.executable, "main.py"),
        (sys.executable, "-m", "main"),
        ("./main.py",),
    ],
)
def test_a_program_that_is_deleted_and_restored_has_not_changed(scene: Scene, argv):
    scene.main.write_text(f"#!{sys.executable}\nimport own\n")
    scene.main.chmod(0o755)
    scene.settle()
    program = WatchedProgram(argv, dict(os.environ), str(scene.folder))
    for name in ("a", "b"):
        assert scene.watched.add_process(name, program, LATER_NS) == []
    content = scene.main.read_text()
    scene.main.unlink()
    assert scene.settle() == [Deleted(str(scene.main), ("a", "b"))]
    scene.main.write_text(content)
    assert scene.settle() == []
    scene.main.unlink()
    assert scene.settle() == [Deleted(str(scene.main), ("a", "b"))]
    scene.main.write_text(f"{content}# other\n")
    (changed,) = scene.settle()
    assert isinstance(changed, Changed) and changed.paths == (str(scene.main),)


def test_a_program_that_was_started_while_it_was_deleted_is_started_when_it_is_there(scene: Scene):
    content = scene.main.read_text()
    scene.main.unlink()
    scene.settle()
    for name in ("a", "b"):  # as after a crash: the interpreter says that there is no such file
        scene.start(name)
    scene.main.write_text(content)
    assert restarts(scene.settle()) == ["a", "b"]


@pytest.mark.parametrize("options", [(), ("-u",)])
def test_a_program_that_is_deleted_is_not_started_though_another_file_has_changed(
    scene: Scene, options
):
    program = WatchedProgram((sys.executable, *options, str(scene.main)), {}, str(scene.folder))
    for name in ("a", "b"):
        assert scene.watched.add_process(name, program, LATER_NS) == []
    scene.main.unlink()
    scene.own.write_text(MODULE.format(2))
    assert scene.settle() == [Deleted(str(scene.main), ("a", "b"))]


def test_a_new_import_that_is_withdrawn_is_no_change(scene: Scene):
    other = scene.folder / "other.py"
    other.write_text("Y = (\n")
    scene.own.write_text("import other\n")
    assert [type(one) for one in scene.settle()] == [Broken]
    scene.own.write_text(MODULE.format(1))
    assert scene.settle() == []
    other.write_text("Y = 1\n")
    assert scene.settle() == []
    scene.own.write_text(MODULE.format(2))
    (changed,) = scene.settle()
    assert isinstance(changed, Changed) and changed.paths == (str(scene.own),)


def test_parameters_that_are_deleted_hold_the_restart(scene: Scene):
    scene.parameters.unlink()
    scene.own.write_text(MODULE.format(2))
    reports = scene.settle()
    assert restarts(reports) == ["a"]
    assert Deleted(str(scene.parameters), ("b",)) in reports


def test_files_that_still_change_hold_their_processes(scene: Scene):
    scene.own.write_text(MODULE.format(2))
    changed = list(scene.watched.look())
    assert restarts(scene.watched.settled(changed, busy=[str(scene.parameters)])) == ["a"]
    assert restarts(scene.watched.settled([str(scene.parameters)])) == ["b"]


def test_a_file_that_has_changed_after_the_start_of_its_process_is_a_change(scene: Scene):
    changed = scene.start("c", started_ns=1)
    assert changed == [str(scene.main), str(scene.own)]
    assert restarts(scene.watched.settled(changed)) == ["c"]
    assert scene.start("c", started_ns=1) == []  # this was to be loaded


def test_a_start_does_not_hide_a_change_from_those_that_have_run_before(scene: Scene):
    scene.own.write_text(MODULE.format(2))
    changed = scene.start("c")  # after the change, and before it was noticed
    assert changed == [str(scene.own)]
    assert restarts(scene.watched.settled(changed)) == ["a", "b"]


def test_a_link_that_leads_elsewhere_has_changed(scene: Scene):
    for number in (1, 2):
        (scene.folder / f"own{number}").write_text(MODULE.format(number))
    scene.own.unlink()
    scene.own.symlink_to("own1")
    assert scene.settle() == []
    scene.own.unlink()
    scene.own.symlink_to("own2")
    assert restarts(scene.settle()) == ["a", "b"]
    (scene.folder / "own2").write_text(MODULE.format(5))
    assert restarts(scene.settle()) == ["a", "b"]


def test_swap_files_and_byte_code_are_not_watched(scene: Scene):
    for name in (".own.py.swp", "own.py~", "4913", "__pycache__/own.cpython-311.pyc"):
        (scene.folder / name).parent.mkdir(exist_ok=True)
        (scene.folder / name).write_text("x")
    assert scene.settle() == []
    assert {Path(path).name for path in scene.watched.paths} == {
        "main.py",
        "own.py",
        "parameters.yaml",
    }


def test_what_is_forgotten_is_not_watched(scene: Scene):
    scene.watched.forget("a")
    scene.watched.forget("b")
    assert scene.watched.paths == []


def test_the_launch_file_is_told_whatever_is_in_it(scene: Scene):
    file = scene.folder / "x.launch.py"
    file.write_text("1")
    scene.watched.add_launch([str(file)], LATER_NS)
    file.write_text("(")
    (changed,) = scene.settle()
    assert isinstance(changed, Changed) and changed.launch and changed.processes == ()


def test_byte_code_of_a_file_that_was_changed_is_deleted(scene: Scene):
    import importlib.util
    import py_compile

    code = Path(importlib.util.cache_from_source(str(scene.own)))
    py_compile.compile(str(scene.own), cfile=str(code))
    scene.own.write_text(MODULE.format(7))
    scene.settle()
    assert not code.exists()


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("", None),
        ("/**:\n  ros__parameters:\n", None),
        ("ns:\n  node:\n    ros__parameters: {a: [1, 2]}\n", None),
        ("node: {ros__parameters: {a: {b: 1}}}\n", None),
        ("- 1\n", ":1: expected the name of a node, and 'ros__parameters:' below it"),
        ("a: 1\n", ":1: expected 'ros__parameters:' below 'a'"),
        ("node:\n  ros__parameters: 3\n", ":2: expected names and values below 'ros__param"),
        ("node:\n  ros__parameters:\n    a: [1\n", ":4: "),
        ("node:\n\tx: 1\n", ":2: found character '\\t' that cannot start any token"),
        ("a: !!python/object:x 1\n", ":1: could not determine a constructor"),
    ],
)
def test_the_form_of_parameter_files(tmp_path: Path, text: str, error: str | None):
    file = tmp_path / "p.yaml"
    file.write_text(text)
    found = file_checks.error_in(str(file), is_parameters=True)
    assert (found is None) == (error is None)
    if found is not None and error is not None:
        assert f"{file}{error}" in found.render()


@pytest.mark.parametrize("content", [b"\0", b"x = '\xff'\n", b"(" * 500])
def test_python_that_cannot_be_read_is_an_error_not_an_exception(tmp_path: Path, content: bytes):
    file = tmp_path / "x.py"
    file.write_bytes(content)
    assert file_checks.error_in(str(file), is_parameters=False) is not None


@pytest.mark.parametrize(
    "argv",
    [
        (sys.executable, "node.py"),
        (sys.executable, "-u", "node.py"),
        ("nice", "-n", "5", sys.executable, "node.py"),
        ("/no/such/python", "node.py"),
        (sys.executable, "-m", "node"),
    ],
)
def test_which_program_a_command_runs(tmp_path: Path, argv: tuple[str, ...]):
    (tmp_path / "node.py").write_text("import beside\n")
    (tmp_path / "beside.py").write_text("")
    program = WatchedProgram(argv, dict(os.environ), str(tmp_path))
    assert files_of(program) == [str(tmp_path / "node.py"), str(tmp_path / "beside.py")]


def test_a_program_that_is_no_python_is_its_own_file(tmp_path: Path):
    program = WatchedProgram(("./node", "x"), {}, str(tmp_path))
    assert files_of(program) == [str(tmp_path / "node")]
    assert files_of(WatchedProgram(("/bin/sh", "-c", "exec sleep 1"), {}, None)) == []
