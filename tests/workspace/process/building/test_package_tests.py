"""`pkg create` and `test`: real packages, built once, whose tests end in all ways."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests.support.children import is_alive
from tests.support.verbs import Answer
from tests.support.waiting import wait_until
from tests.support.workspaces import build, launcher

LAUNCHER = [sys.executable, "-m", "launcher"]


def make(root: Path, *packages: tuple[str, ...]) -> None:
    """Make packages in a workspace."""
    (root / "src").mkdir(parents=True, exist_ok=True)
    for words in packages:
        answer = launcher(root, "pkg", "create", *words)
        assert answer.code == 0, answer


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A workspace with three packages of nodes, and one that is not built.

    It is in a checkout whose configuration of pytest would break every run.
    """
    checkout = tmp_path_factory.mktemp("w ö")
    (checkout / "pytest.ini").write_text("[pytest]\naddopts = --unknown\n", encoding="utf-8")
    root = checkout / "ws"
    make(root, ("new_one",), ("first",), ("second",))
    build(root)
    make(root, ("not_built",))
    return root


@pytest.fixture
def workspace(built: Path) -> Path:
    """The same, where `first` and `second` have no tests yet."""
    for name in ("first", "second"):
        for path in (built / "src" / name / "test").glob("*.py"):
            path.unlink()
    return built


def give(workspace: Path, package: str, text: str, name: str = "test_it.py") -> Path:
    """Give a package a file of tests."""
    path = workspace / "src" / package / "test" / name
    path.write_text(text, encoding="utf-8")
    return path


# ---- what passes


@pytest.mark.thorough
def test_a_new_package_passes_its_own_tests(built):
    answer = launcher(built, "test", "new_one")

    assert answer.code == 0, answer
    assert answer.lines[-1] == "1 package: 2 passed"
    cases = ElementTree.parse(built / "build/new_one/pytest.xml").getroot().iter("testcase")
    assert {case.get("name") for case in cases} == {
        "test_it_counts[NewOneNode]",
        "test_all_nodes_publish_and_stop",
    }


DOMAIN = """\
import os
from pathlib import Path

def test_domain():
    names = ("ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE")
    Path(__file__).with_suffix(".txt").write_text(" ".join(os.environ[name] for name in names))
"""


@pytest.mark.thorough
def test_each_package_has_a_domain_of_its_own(workspace):
    files = [give(workspace, name, DOMAIN).with_suffix(".txt") for name in ("first", "second")]

    answer = launcher(workspace, "test", "first", "second")

    assert (answer.code, answer.err) == (0, "")  # new tests need no build
    assert sorted(answer.lines[:2]) == [
        f"first: 1 passed ({_time(answer, 'first')} s)",
        f"second: 1 passed ({_time(answer, 'second')} s)",
    ]
    domains, ranges = zip(*(file.read_text().split() for file in files), strict=True)
    assert len({*domains}) == 2
    assert {*ranges} == {"LOCALHOST"}


def _time(answer: Answer, package: str) -> str:
    found = re.search(rf"^{package}: .*\(([\d.]+) s\)$", answer.out, re.MULTILINE)
    assert found is not None, answer
    return found[1]


@pytest.mark.thorough
def test_options_behind_two_dashes_are_those_of_pytest(workspace):
    give(workspace, "first", "def test_one(): pass\ndef test_two(): assert False\n")

    answer = launcher(workspace, "test", "first", "--", "-k", "one", "-v")

    assert answer.code == 0, answer
    assert "test/test_it.py::test_one PASSED" in answer.out


# ---- what fails

FAILING = """\
import pytest

@pytest.fixture
def broken():
    raise RuntimeError("in the fixture")

def equal(a, b):
    assert a == b, "first line\\nsecond line"

def test_good(): pass
def test_bad(): equal(1, 2)
def test_worse(broken): pass
@pytest.mark.skip
def test_not(): pass

def test_loud():
    for number in range(100):
        print("{name}", number)
    assert False
"""


@pytest.mark.thorough
def test_failures_are_told_with_their_places_and_outputs_do_not_mix(workspace):
    for name in ("first", "second"):
        give(workspace, name, FAILING.replace("{name}", name))

    answer = launcher(workspace, "test", "first", "second")

    assert answer.code == 1
    for name in ("first", "second"):
        file = f"src/{name}/test/test_it.py"
        last = len(FAILING.splitlines())
        assert f"failed: {file}:8: test_bad: AssertionError: first line" in answer.lines
        assert f"failed: {file}:5: test_worse: failed on setup with" in answer.out
        assert f"failed: {file}:{last}: test_loud: assert False" in answer.lines
        assert re.search(rf"^{name}: 1 passed, 3 failed, 1 skipped \(", answer.out, re.MULTILINE)
    assert answer.lines[-1] == "2 packages: 2 passed, 6 failed, 2 skipped"
    loud = [line.split()[0] for line in answer.lines if re.fullmatch(r"(first|second) \d+", line)]
    assert loud in (sorted(loud), sorted(loud, reverse=True)), "the outputs are mixed"


@pytest.mark.thorough
def test_a_workflow_gets_annotations_and_a_summary(workspace, tmp_path):
    give(workspace, "first", "def test_bad(): assert False\n")
    path = tmp_path / "summary.md"
    variables = {"GITHUB_ACTIONS": "true", "GITHUB_STEP_SUMMARY": str(path)}

    answer = launcher(workspace, "test", "first", **variables)

    place = "file=src/first/test/test_it.py,line=1"
    assert f"::error {place},title=first%3A test_bad::assert False" in answer.lines
    assert "| FAILED | first | 1 failed |" in path.read_text(encoding="utf-8").splitlines()
    assert "::error" not in launcher(workspace, "test", "first", "--no-github", **variables).out


@pytest.mark.thorough
def test_of_a_long_output_the_end_is_printed_and_the_file_named(workspace):
    give(workspace, "first", FAILING.replace("100", "5000"))
    give(workspace, "second", "def test_good(): pass\n")

    answer = launcher(workspace, "test", "first", "second")

    assert "... all of it: build/first/test.log" in answer.lines
    assert len(answer.lines) < 400
    assert "{name} 4999" in (workspace / "build/first/test.log").read_text(encoding="utf-8")


@pytest.mark.thorough
def test_a_missing_linter_is_told_with_the_words_that_leave_it_out(workspace):
    give(workspace, "first", "import ament_copyright.main\n", "test_copyright.py")

    answer = launcher(workspace, "test", "first")

    assert answer.code == 1
    place = "src/first/test/test_copyright.py:1"
    assert f"failed: {place}: test.test_copyright: ModuleNotFoundError" in answer.out
    assert "test -- --ignore-glob='*/test_copyright.py'" in answer.out


@pytest.mark.thorough
def test_a_process_that_dies_is_told(workspace):
    give(workspace, "first", "import os\ndef test_crash(): os.abort()\n")
    answer = launcher(workspace, "test", "first")
    assert (answer.code, "first: killed by SIGABRT" in answer.lines) == (1, True), answer


@pytest.mark.thorough
def test_without_any_test_the_exit_code_is_1(workspace):
    answer = launcher(workspace, "test", "first")

    assert (answer.code, answer.err) == (1, "no test ran\n")
    assert answer.lines[-1] == "1 package: no tests"


@pytest.mark.thorough
def test_a_skipped_test_has_not_run(workspace):
    give(workspace, "first", "import pytest\n@pytest.mark.skip\ndef test_it(): pass\n")
    answer = launcher(workspace, "test", "first")
    assert (answer.code, answer.err, answer.lines[-1]) == (
        1,
        "no test ran\n",
        "1 package: 1 skipped",
    )


# ---- what is told before


@pytest.mark.thorough
def test_a_package_that_is_not_built_is_not_tested(workspace):
    give(workspace, "first", "def test_good(): pass\n")

    answer = launcher(workspace, "test", "first", "not_built")

    assert answer.code == 1
    assert "warning: not built: not_built; to build it: python -m launcher build\n" in answer.err
    assert "not_built: not built" in answer.lines
    assert answer.lines[-1] == "2 packages: 1 passed, 1 not built (not_built)"


@pytest.mark.thorough
def test_a_stale_build_is_told_and_tested(workspace):
    give(workspace, "second", "def test_good(): pass\n")
    setup = workspace / "src/second/setup.cfg"
    before = setup.read_text(encoding="utf-8")
    try:
        setup.write_text(f"{before}\n", encoding="utf-8")
        answer = launcher(workspace, "test", "second")
    finally:
        setup.write_text(before, encoding="utf-8")

    assert answer.code == 0, answer
    assert "warning: the build of second is stale" in answer.err


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["frist"], "hint: did you mean 'first'?"),
        (["first", "--pdb"], "hint: options of pytest go behind --: "),
        (["--timeot", "3"], "hint: did you mean '--timeout'?"),
        (["--timeout", "0"], "is not a number of seconds above 0"),
        (["--parallel-workers", "0"], "is not a whole number of at least 1"),
    ],
)
def test_mistakes_of_the_command_line(workspace, words, sentence):
    answer = launcher(workspace, "test", *words)
    assert (answer.code, answer.out) == (2, "")
    assert sentence in answer.err


def test_outside_of_a_workspace_is_an_error(tmp_path):
    answer = launcher(tmp_path, "test")
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith("error: no workspace at ")


# ---- nothing is left

LEAVING = """\
import subprocess, sys
from pathlib import Path

SLEEP = [sys.executable, "-c", "import time; time.sleep(1000)"]

def test_leave():
    plain = subprocess.Popen(SLEEP)
    session = subprocess.Popen(SLEEP, start_new_session=True)
    stranger = subprocess.Popen(SLEEP, start_new_session=True, env={})
    pids = [str(one.pid) for one in (plain, session, stranger)]
    Path(__file__).with_suffix(".new").write_text(" ".join(pids))
    Path(__file__).with_suffix(".new").rename(Path(__file__).with_suffix(".txt"))
    {end}
"""


def left_alive(file: Path) -> list[int]:
    return [pid for pid in map(int, file.read_text().split()) if is_alive(pid)]


@pytest.mark.thorough
def test_what_tests_leave_behind_is_told_and_stopped(workspace):
    file = give(workspace, "first", LEAVING.replace("{end}", "pass")).with_suffix(".txt")
    file.unlink(missing_ok=True)

    answer = launcher(workspace, "test", "first")

    assert answer.code == 0, answer
    assert "warning: first left a process behind, which was stopped: " in answer.err
    assert left_alive(file) == []


@contextlib.contextmanager
def hanging_test(workspace: Path, *words: str) -> Iterator[tuple[subprocess.Popen[str], Path]]:
    """`launcher test`, once the test of `first` hangs; and the file with pids."""
    end = "import time; time.sleep(1000)"
    file = give(workspace, "first", LEAVING.replace("{end}", end)).with_suffix(".txt")
    file.unlink(missing_ok=True)
    program = subprocess.Popen(
        [*LAUNCHER, "test", *words],
        cwd=workspace,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        wait_until(lambda: file.exists() or program.poll() is not None, "the test hangs")
        yield program, file
    finally:
        program.kill()
        program.communicate()


@pytest.mark.thorough
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_a_signal_ends_the_tests_and_all_that_they_started(workspace, number):
    with hanging_test(workspace, "first", "second") as (program, file):
        program.send_signal(number)
        out, _ = program.communicate(timeout=60)
        wait_until(lambda: not left_alive(file), "all processes have ended")

    if number != signal.SIGKILL:
        assert program.returncode == {signal.SIGINT: 130, signal.SIGTERM: 143}[number]
        assert "first: interrupted" in out.splitlines()


@pytest.mark.thorough
def test_a_second_run_waits_for_the_first(workspace):
    with hanging_test(workspace, "first") as (first, _):
        give(workspace, "second", "def test_good(): pass\n")
        second = subprocess.Popen(
            [*LAUNCHER, "test", "second"], cwd=workspace, stderr=subprocess.PIPE, text=True
        )
        assert second.stderr is not None
        line = second.stderr.readline()
        assert line.startswith(f"waiting for process {first.pid}, ")
        first.send_signal(signal.SIGINT)
        first.communicate(timeout=60)
        assert second.wait(60) == 0
        second.stderr.close()


@pytest.mark.thorough
@pytest.mark.parametrize("ignores", [False, True], ids=["plain", "ignores SIGINT"])
def test_a_test_that_hangs_is_ended_with_its_place(workspace, ignores):
    first = "    signal.signal(signal.SIGINT, signal.SIG_IGN)\n" if ignores else "    pass\n"
    text = f"import signal, time\ndef test_hang():\n{first}    time.sleep(1000)\n"
    give(workspace, "first", text)
    give(workspace, "second", "def test_good(): pass\n")

    answer = launcher(workspace, "test", "first", "second", "--timeout", "20")

    assert answer.code == 1
    assert "first: timed out after 20 s, at src/first/test/test_it.py:4" in answer.lines
    assert answer.lines[-1] == "2 packages: 1 passed, 1 timed out (first)"


# ---- own types


@pytest.mark.thorough
def test_new_packages_of_nodes_and_interfaces_work_together(tmp_path):
    """By pytest, by ctest as built with BUILD_TESTING, and for colcon."""
    make(
        tmp_path,
        ("demo", "--node", "alpha", "--node", "beta", "--interfaces"),
        ("more_msgs", "--interfaces", "--dependencies", "demo_interfaces"),
    )
    message = tmp_path / "src/more_msgs/msg/Count.msg"
    message.write_text(f"{message.read_text()}demo_interfaces/Count other\n")
    build(tmp_path)

    shown = launcher(tmp_path, "interface", "show", "more_msgs/msg/Count")
    assert "demo_interfaces/Count other" in shown.out, shown
    answer = launcher(tmp_path, "test")
    assert (answer.code, answer.lines[-1]) == (0, "3 packages: 19 passed"), answer

    seen = colcon_results(tmp_path)
    assert "build/demo/pytest.xml: 5 tests, 0 errors, 0 failures, 0 skipped" in seen
    assert "build/demo_interfaces/pytest.xml: 7 tests, 0 errors, 0 failures, 0 skipped" in seen

    build(tmp_path, "src/demo_interfaces", "--", "--cmake-args", "-DBUILD_TESTING=ON")
    answer = launcher(tmp_path, "test", "demo_interfaces")
    assert (answer.code, answer.lines[-1]) == (0, "1 package: 7 passed"), answer
    assert "100% tests passed" in answer.out
    assert "test_demo_interfaces.xunit.xml: 7 tests" in colcon_results(tmp_path)


def colcon_results(workspace: Path) -> str:
    """What `colcon test-result` finds."""
    colcon = os.path.join(os.path.dirname(sys.executable), "colcon")
    command = [colcon, "test-result", "--all"]
    done = subprocess.run(command, cwd=workspace, text=True, stdout=subprocess.PIPE, check=True)
    return done.stdout
