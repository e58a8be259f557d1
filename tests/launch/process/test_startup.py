"""What is imported on the way from the command line to the first process.

Every start of a system waits for it. What may wait itself is imported in a function, or when the
first processes run; a new name here needs a reason, and a look at `python -m benchmarks first`.
"""

from __future__ import annotations

import os
import random
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.support.loaded_modules import loaded_by_run, loaded_modules
from tests.support.repository import REPOSITORY

# From the standard library, with all that these need themselves. `_ctypes`, for prctl: an orphan
# must be ours before there is one, and ctypes itself would take eight times as long.
ALLOWED = """__future__ _ctypes collections.abc contextlib enum errno fcntl fnmatch functools gc
    importlib.util re runpy select signal"""
MAX_OWN_MODULES = 95  # as many as there were when this was written, 20 of them packages

# Tells which modules there are when the launcher starts the first program of the launch file.
TELL = """
import os, runpy, sys

def tell(event, args):
    if event == "os.posix_spawn" and args[0] == "/bin/true":
        with os.fdopen(os.dup(2), "w") as out:
            print(*sys.modules, file=out)
        os._exit(0)  # what comes after it is not what this is about

sys.addaudithook(tell)
sys.argv = ["launcher", sys.argv[1], "--no-log-files"]
runpy.run_module("launcher", run_name="__main__", alter_sys=True)
"""

# Somebody presses Ctrl-C when this module is about to be imported.
INTERRUPT = """
import runpy, signal, sys

def press(event, args):
    if event == "import" and args[0] == {module!r}:
        signal.raise_signal(signal.SIGINT)

sys.addaudithook(press)
sys.argv = ["launcher", sys.argv[1], "--no-log-files"]
runpy.run_module("launcher", run_name="__main__", alter_sys=True)
"""

# What pip installs as the command `launcher`.
SCRIPT = "import sys; from launcher.__main__ import main; sys.exit(main())"

LAUNCH_FILE = """
from launch import LaunchDescription
from launch.actions import ExecuteProcess

def generate_launch_description():
    return LaunchDescription([ExecuteProcess(cmd=["/bin/true"], output="screen")])
"""


def python(*words: str) -> str:
    """The first line that a Python without site-packages writes to standard error."""
    # A domain above 99 is looked at more closely, which imports more.
    env = {**os.environ, "PYTHONPATH": str(REPOSITORY), "ROS_DOMAIN_ID": "0"}
    command = [sys.executable, "-S", "-c", *words]
    done = subprocess.run(command, env=env, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return done.stderr.splitlines()[0]


@pytest.fixture
def imported(tmp_path: Path) -> set[str]:
    """The modules that are there when the first program is started."""
    file = tmp_path / "one.launch.py"
    file.write_text(LAUNCH_FILE, encoding="utf-8")
    return set(python(TELL, str(file)).split())


def test_little_of_the_standard_library_is_imported_before_the_first_process(imported: set[str]):
    names = ", ".join(ALLOWED.split())
    allowed = python(f"import sys, {names}\nprint(*sys.modules, file=sys.stderr)").split()
    assert {name for name in imported if not is_ours(name)} - set(allowed) == set()


def test_few_modules_of_the_launcher_are_imported_before_the_first_process(imported: set[str]):
    ours = sorted(name for name in imported if is_ours(name))
    assert len(ours) <= MAX_OWN_MODULES, ours


def test_a_run_without_a_hosts_file_imports_nothing_for_hosts(tmp_path: Path):
    file = tmp_path / "one.launch.py"
    file.write_text(LAUNCH_FILE.replace('["/bin/true"]', '["sleep", "0.2"]'), encoding="utf-8")
    modules = loaded_by_run(file)
    assert "launcher.run.ending.shutdown" in modules
    hosts = ("launcher.hosts", "launcher.hosts.engine", "launcher.hosts.agent")
    assert [name for name in modules if name.startswith(hosts)] == []


@pytest.mark.parametrize(
    "action",
    [
        'ExecuteProcess(cmd=[sys.executable, "-m", "this"])',
        'Node(executable="/bin/sleep", arguments=["0.2"])',
        'Node(executable=sys.executable, arguments=["-c", "pass"])',
    ],
)
def test_a_run_without_python_nodes_imports_nothing_for_warm_starts(tmp_path: Path, action: str):
    file = tmp_path / "one.launch.py"
    text = LAUNCH_FILE.replace('ExecuteProcess(cmd=["/bin/true"], output="screen")', action)
    assert action in text
    file.write_text(f"import sys\nfrom launch_ros.actions import Node\n{text}", encoding="utf-8")
    modules = loaded_by_run(file)
    assert "launcher.run.ending.shutdown" in modules
    assert [name for name in modules if name.startswith("launcher.run.warm")] == []


# Reports who imports one of the LARGE modules, on standard error.
WATCHED = """
import sys, traceback

class Watch:
    def find_spec(self, name, path=None, target=None):
        if name in %r:
            print("LARGE:", name, *traceback.format_stack(), file=sys.stderr)

sys.meta_path.insert(0, Watch())
"""
LARGE = {"hashlib", "random", "shutil", "tempfile", "psutil", "subprocess"}


def test_an_idle_run_imports_nothing_large(tmp_path: Path):
    """With all that follows the start: control socket, samples, log files, plan, summary."""
    file = tmp_path / "one.launch.py"
    sampled = f"grep -qs resources {tmp_path}/log/latest/events.jsonl"
    command = ["sh", "-c", f"until {sampled}; do sleep 0.1; done"]
    file.write_text(LAUNCH_FILE.replace('["/bin/true"]', repr(command)), encoding="utf-8")
    modules, errors = loaded_modules(
        str(file), options=["-S"], prologue=WATCHED % LARGE, ROS_LOG_DIR=str(tmp_path / "log")
    )
    assert {"launcher.control.control_service", "launcher.run.monitor.resources"} <= modules
    assert "launcher.launch.run_plan" in modules
    assert modules & LARGE == set(), errors


def test_the_watchdog_imports_little():
    code = f"""if True:
        import sys
        before = set(sys.modules)
        sys.path.append({str(REPOSITORY)!r})
        import launcher.posix.cleanup.run_watch, launcher.posix.cleanup.watchdog
        print(*(set(sys.modules) - before))
    """
    command = [sys.executable, "-I", "-S", "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    modules = {name for name in done.stdout.split() if not is_ours(name)}
    ours = "__future__ _collections_abc _stat genericpath os os.path posixpath select stat"
    assert modules <= set(ours.split())


def test_outside_of_a_workspace_nothing_is_imported_but_what_looks_for_it(imported: set[str]):
    found = {
        name for name in imported if name.startswith(("launcher.packages", "launcher.workspace"))
    }
    assert found == {
        "launcher.packages",
        "launcher.packages.distribution",
        "launcher.packages.workspace",
    }


@pytest.mark.parametrize(
    "module", ["launcher.cli.dispatch", "launcher.base.errors", "launcher.posix.spawn"]
)
def test_ctrl_c_before_the_first_process_ends_the_command_without_a_word(tmp_path, module: str):
    file = tmp_path / "one.launch.py"
    file.write_text(LAUNCH_FILE, encoding="utf-8")
    command = [sys.executable, "-S", "-c", INTERRUPT.format(module=module), str(file)]
    env = {**os.environ, "PYTHONPATH": str(REPOSITORY)}
    done = subprocess.run(command, env=env, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")


IN_SET_NAME = """
import sys
from launcher.__main__ import main
from {module} import {property}

before = {property}.__set_name__

def interrupt(self, owner, name):
    before(self, owner, name)
    if owner.__name__ == "{owner}":
        raise KeyboardInterrupt

{property}.__set_name__ = interrupt
sys.exit(main())
"""


@pytest.mark.parametrize(
    ("module", "property", "owner"),
    [
        ("functools", "cached_property", "RunDirectory"),
        ("launcher.language.naming", "_ReadOnly", "ExecuteLocal"),  # by the launch file
    ],
)
def test_ctrl_c_while_a_class_is_made_ends_the_command_without_a_word(
    tmp_path: Path, module: str, property: str, owner: str
):
    file = tmp_path / "one.launch.py"
    file.write_text(LAUNCH_FILE, encoding="utf-8")
    code = IN_SET_NAME.format(module=module, property=property, owner=owner)
    command = [sys.executable, "-S", "-c", code, str(file)]
    env = {**os.environ, "PYTHONPATH": str(REPOSITORY)}
    done = subprocess.run(command, env=env, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")


#: A line of ours in a traceback. Where the package and the module begin, a Ctrl-C is noticed
#: before the `try` of the module.
OURS = re.compile(
    re.escape(f"{REPOSITORY}/launcher/") + r'(?!(__init__|__main__)\.py", line [01], in <module>)'
)


@pytest.mark.parametrize("words", [("-m", "launcher"), ("-c", SCRIPT)], ids=["module", "script"])
def test_no_traceback_of_an_early_ctrl_c_is_ours(tmp_path: Path, words: tuple[str, ...]):
    """Before our first line, Python may print one; nothing of ours runs then."""
    file = tmp_path / "one.launch.py"
    file.write_text(LAUNCH_FILE, encoding="utf-8")
    chance = random.Random(28)
    for _ in range(40):
        with subprocess.Popen(
            [sys.executable, "-S", *words, str(file), "--no-log-files"],
            env={**os.environ, "PYTHONPATH": str(REPOSITORY)},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        ) as run:
            time.sleep(chance.uniform(0.0, 0.06))  # an aim, not a deadline
            run.send_signal(signal.SIGINT)
            _, errors = run.communicate(timeout=60)
        assert not OURS.search(errors), errors


AT_MAIN = """
import os, runpy, signal, sys

def trace(frame, event, argument):
    code = frame.f_code
    if code.co_name != "main" or not code.co_filename.endswith("/launcher/__main__.py"):
        return None
    if event == "{event}":
        sys.settrace(None)
        os.kill(os.getpid(), signal.SIGINT)
    return trace

signal.signal(signal.SIGINT, {handler})
sys.argv = ["launcher", "--version"]
sys.settrace(trace)
{start}
"""


@pytest.mark.parametrize(
    "start", ['runpy.run_module("launcher", run_name="__main__")', SCRIPT], ids=["module", "script"]
)
def test_a_ctrl_c_as_main_begins_ends_it_silently(start: str):
    """Python notices a Ctrl-C where a function begins, before its `try`."""
    code = AT_MAIN.format(event="call", handler="signal.default_int_handler", start=start)
    done = python_with(code)
    assert (done.returncode, done.stdout, done.stderr) == (-signal.SIGINT, "", "")


def test_a_ctrl_c_after_the_last_line_of_main_leaves_no_traceback():
    start = 'runpy.run_module("launcher", run_name="__main__")'
    code = AT_MAIN.format(event="return", handler="signal.default_int_handler", start=start)
    done = python_with(code)
    assert (done.returncode, done.stderr) == (130, "")


def test_a_ctrl_c_that_is_ignored_is_taken_over():
    """As in a background job of a script."""
    done = python_with(AT_MAIN.format(event="call", handler="signal.SIG_IGN", start=SCRIPT))
    assert (done.returncode, done.stdout, done.stderr) == (-signal.SIGINT, "", "")


def python_with(code: str) -> subprocess.CompletedProcess[str]:
    env = {**os.environ, "PYTHONPATH": str(REPOSITORY)}
    command = [sys.executable, "-c", code]
    return subprocess.run(command, env=env, capture_output=True, text=True, check=False)


def is_ours(name: str) -> bool:
    return name.partition(".")[0] in ("launcher", "launch")
