"""Tests of launch_testing as users write them, run by the program and by pytest."""

from __future__ import annotations

import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

HEAD = """
import sys, unittest
import launch, launch_testing, launch_testing.actions, launch_testing.asserts, pytest
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration

PROGRAM = "import sys, time; print('ready', *sys.argv[1:], flush=True); time.sleep(1000)"

def description(*words, program=PROGRAM, name="talker"):
    process = ExecuteProcess(cmd=[sys.executable, "-c", program, *words], name=name)
    return launch.LaunchDescription([
        DeclareLaunchArgument("word", default_value="none", description="what is said"),
        process,
        launch_testing.actions.ReadyToTest(),
    ]), {"talker": process}
"""

WORKS = """
@pytest.mark.launch_test
def generate_test_description():
    return description(LaunchConfiguration("word"))

class TestRunning(unittest.TestCase):
    def test_output(self, proc_output, proc_info, talker, test_args):
        proc_info.assertWaitForStartup(process=talker, timeout=60)
        proc_output.assertWaitFor("ready " + test_args.get("word", "none"), process="talker",
                                  stream="stdout", timeout=60)

    def test_attributes(self):
        assert self.launch_service is not None and self.proc_info is not None

@launch_testing.post_shutdown_test()
class TestEnded(unittest.TestCase):
    def test_codes(self, proc_info, proc_output, talker):
        assert proc_info[talker].returncode != 0
        launch_testing.asserts.assertInStdout(proc_output, "ready", talker)
        with launch_testing.asserts.assertSequentialStdout(proc_output, "talker") as checker:
            checker.assertInStdout("rea")
            checker.assertInStdout("dy")
"""

FAILS = """
@pytest.mark.launch_test
@launch_testing.parametrize("number", [1, 2])
def generate_test_description(number):
    return description()[0]

class TestRunning(unittest.TestCase):
    def test_number(self, number):
        self.assertEqual(number, 1)
"""

DIES = """
@pytest.mark.launch_test
def generate_test_description():
    return description(program="print('the reason'); raise SystemExit(3)")[0]

class TestRunning(unittest.TestCase):
    def test_waits(self, proc_output):
        import threading
        threading.Event().wait()
"""


def run(words: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", *words], cwd=folder, text=True, capture_output=True, timeout=300
    )


def launch_test(folder: Path, text: str, *words: str) -> subprocess.CompletedProcess[str]:
    (folder / "some_test.py").write_text(HEAD + text)
    return run(["launcher", "launch-test", "some_test.py", *words], folder)


def test_tests_see_processes_while_they_run_and_after(tmp_path: Path):
    words = ("word:=hello", "--junit-xml", "report.xml", "--package-name", "some")
    result = launch_test(tmp_path, WORKS, *words)

    assert result.returncode == 0, result.stdout + result.stderr
    assert "shutdown requested" not in result.stdout
    (suite,) = ET.parse(tmp_path / "report.xml").getroot()
    assert suite.attrib["name"] == "some.some_test.launch_tests"
    assert [case.attrib["name"] for case in suite] == [
        "test_attributes",
        "test_output",
        "test_codes",
    ]
    assert (suite.attrib["failures"], suite.attrib["errors"]) == ("0", "0")


@pytest.mark.thorough
def test_each_set_of_parameters_is_a_run(tmp_path: Path):
    result = launch_test(tmp_path, FAILS, "--junit-xml", "report.xml")

    assert result.returncode == 1
    suites = list(ET.parse(tmp_path / "report.xml").getroot())
    assert [suite.attrib["name"][-3:] for suite in suites] == ["[1]", "[2]"]
    assert [suite.attrib["failures"] for suite in suites] == ["0", "1"]


@pytest.mark.thorough
def test_processes_that_end_before_their_tests_are_a_failure_with_their_output(tmp_path: Path):
    result = launch_test(tmp_path, DIES)

    assert result.returncode == 1
    expected = "Processes under test stopped before tests completed"
    said = result.stdout.splitlines()
    rest = said[said.index(expected) + 1 :]
    assert rest[0] == "Process 'talker-1' exited with 3"
    assert rest[1:3] == ["##### 'talker-1' output #####", "the reason"]
    for text in ("first unexpected exit", "processes of this run"):  # tests judge the exits
        assert text not in result.stdout


@pytest.mark.thorough
def test_arguments_are_listed_and_unusable_files_refused(tmp_path: Path):
    listed = launch_test(tmp_path, WORKS, "--show-args")
    assert listed.returncode == 0
    assert listed.stdout.splitlines() == [
        "Arguments (pass arguments as '<name>:=<value>'):",
        "",
        "    'word':",
        "        what is said",
        "        (default: 'none')",
    ]
    no_ready = "def generate_test_description():\n    return launch.LaunchDescription([])\n"
    for text, message in (
        ("", "some_test.py has no function generate_test_description()"),
        (no_ready, "a LaunchDescription containing a ReadyToTest action"),
        ("def generate_test_description(x): pass\n", "unexpected extra argument 'x'"),
    ):
        refused = launch_test(tmp_path, text)
        assert (refused.returncode, message in refused.stderr) == (2, True), refused.stderr


@pytest.mark.thorough
def test_pytest_collects_marked_descriptions(tmp_path: Path):
    (tmp_path / "test_works.py").write_text(HEAD + WORKS)
    (tmp_path / "test_fails.py").write_text(HEAD + FAILS)
    (tmp_path / "test_plain.py").write_text("def test_plain(): pass\n")
    (tmp_path / "test_it.launch.py").write_text("raise Exception\n")
    words = ["pytest", "-q", "-p", "no:cacheprovider", "--launch-args", "word:=here", "--", "."]
    result = run(words, tmp_path)

    assert result.returncode == 1
    assert "1 failed, 2 passed" in result.stdout, result.stdout
    assert "FAIL: test_fails.TestRunning.test_number[2]" in result.stdout


INSTALLED = {
    "launch_testing/__init__.py": "from launch import LaunchService\n",
    "launch_testing/launch_test.py": (
        "import sys\nfrom launch import LaunchService\n"
        "def main():\n    print('installed', sys.argv[1:], LaunchService.__module__)\n"
    ),
}


def test_installed_packages_go_first_and_find_our_launch(tmp_path: Path, monkeypatch):
    for name, text in INSTALLED.items():
        (tmp_path / "site" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "site" / name).write_text(text)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "site"))
    said = "installed ['some_test.py'] launch.launch_service\n"

    assert launch_test(tmp_path, WORKS).stdout == said
    (tmp_path / "launch").mkdir()  # a folder is no package
    code = "from launch_testing.launch_test import main; main()"
    own = subprocess.run(
        [sys.executable, "-c", code, "some_test.py"], cwd=tmp_path, text=True, capture_output=True
    )
    assert (own.stdout, own.stderr) == (said, "")
    (tmp_path / "site" / "launch.py").write_text("LaunchService = int\n")
    theirs = subprocess.run(
        [sys.executable, "-c", "import launch; print(launch.LaunchService)"],
        cwd=tmp_path,
        text=True,
        capture_output=True,
    )
    assert theirs.stdout == "<class 'int'>\n"


LEGACY = """
import launcher.api
from launch import LaunchDescription, LaunchService
from launch.actions import ExecuteProcess
from launch_testing.legacy import LaunchTestService
from launch_testing.legacy.output import create_output_lines_test

for lines in ([b"hello"], [b"hello", b"nothing"]):
    description, test = LaunchDescription(), LaunchTestService()
    action = test.add_fixture_action(description, ExecuteProcess(cmd=["echo", "hello"]))
    test.add_output_test(description, action, create_output_lines_test(lines))
    service = LaunchService()
    service.include_launch_description(description)
    print("code", test.run(service))
"""


@pytest.mark.thorough
def test_a_legacy_test_fails_for_output_that_does_not_come(tmp_path: Path):
    result = subprocess.run(
        [sys.executable, "-c", LEGACY], cwd=tmp_path, text=True, capture_output=True
    )
    codes = [line for line in result.stdout.splitlines() if line.startswith("code")]

    assert codes == ["code 0", "code 1"], result.stderr
