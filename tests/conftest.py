"""Tiers, workers, and an environment of its own for each worker.

Every test belongs to one tier: `unit`, `basic`, `thorough` or `browser` (see CONTRIBUTING.md).
"""

from __future__ import annotations

import errno
import functools
import gc
import os
import signal
import socket
import sys
import tempfile
from collections.abc import Generator, Iterator
from importlib import metadata
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings
from xdist.scheduler import LoadScopeScheduling

from launcher.packages.distribution import ROS_VARIABLES
from launcher.packages.workspace import is_install
from launcher.posix.domain_lease import leased_domain
from tests.support.waiting import wait_until
from tests.support.workspaces import BuiltWorkspace, example

# Fixtures that tests of several folders use.
pytest_plugins = (
    "tests.support.benches",
    "tests.support.command_folder",
    "tests.support.ros_domain",
)

TIERS = ("unit", "basic", "thorough", "browser")
LAB = "tests/hosts/lab/"  # several hosts on one machine
# A fixture of these takes long, or makes a network with hosts, and serves all tests of the file.
TOGETHER = (
    "tests/workspace/process/building/test_changes.py",
    "tests/workspace/process/building/test_package_tests.py",
    LAB,
    "tests/group_gp1/ros/test_fleet.py",
    "tests/launch/process/test_plan_leaks.py",
    "tests/workspace/process/test_installed_ros.py",
    "tests/workspace/process/test_ros_installation.py",
    "tests/workspace/process/test_workspace.py",
    "tests/ros/ros/test_probe.py",
    "tests/ros/ros/test_processes.py",
    "tests/smoke/process/test_ros_kinds.py",
)
# Folders with tests of a minute.
LONGEST = ("tests/workspace/process/building/", "tests/system/", "tests/smoke/process/")
# They do not wait; and they are short: handing them out one by one would take longer than they do.
UNIT = "/unit/"
WORKERS_PER_CORE, MAX_WORKERS = 3, 12  # most of the time a test waits

# Examples that hypothesis tries: `make thorough` searches, the other tiers repeat the same ones.
settings.register_profile("repeat", max_examples=10, derandomize=True, deadline=None, database=None)
settings.register_profile(
    "search", max_examples=100, derandomize="CI" in os.environ, deadline=None, print_blob=True
)


def pytest_configure(config: pytest.Config) -> None:
    if is_install(str(config.rootpath / "install")):
        # As a workspace, the checkout would change the environment of everything in these tests.
        pytest.exit(
            "colcon has built this checkout: rm -r build install log", pytest.ExitCode.USAGE_ERROR
        )
    _handle_signals()
    if config.getoption("--hypothesis-profile", None) is None:
        settings.load_profile("repeat")


def pytest_collection_finish() -> None:
    """Let tests begin with the same handlers: those of imports count no longer."""
    _handle_signals()
    gc.freeze()  # twelve thousand tests stay, and each collection would look through them


def _handle_signals() -> None:
    """With `&` or nohup signals are ignored, and children would inherit that.

    They do not inherit handlers. `launcher.__main__` leaves Ctrl-C to the kernel while it imports.
    """
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for number in (signal.SIGHUP, signal.SIGQUIT):
        if signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, lambda *_: None)


def pytest_xdist_auto_num_workers() -> int:
    return min(WORKERS_PER_CORE * len(os.sched_getaffinity(0)), MAX_WORKERS)


def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> LoadScopeScheduling:
    config.option.loadscopereorder = False
    return Scheduling(config, log)


class Scheduling(LoadScopeScheduling):
    """Hands out tests one by one in their order, but those of `TOGETHER` by file."""

    def _split_scope(self, nodeid: str) -> str:
        file = nodeid.partition("::")[0]
        return file if UNIT in file or file.startswith(TOGETHER) else nodeid


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    gc.disable()  # it would look through all tests again and again, and nothing is garbage
    try:
        return (yield)
    finally:
        gc.enable()


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> Iterator[None]:
    for item in items:
        tiers = [mark.name for mark in item.iter_markers() if mark.name in TIERS]
        if not tiers:
            tiers = [_tier(item.nodeid)]
            item.add_marker(tiers[0])
        elif len(set(tiers)) > 1:
            raise pytest.UsageError(f"{item.nodeid} belongs to more than one tier: {tiers}")
        item.user_properties.append(("tier", tiers[0]))  # for tools/tiers.py
    yield  # here pytest leaves out the tiers that were not asked for
    files = [list(tests) for _, tests in groupby(items, key=lambda item: item.path)]
    waiting = [file for file in files if not _never_waits(file[0].nodeid)]
    waiting.sort(key=lambda file: not file[0].nodeid.startswith(LONGEST))
    others = [file for file in files if _never_waits(file[0].nodeid)]
    # Those that never wait use the processor while others wait, and while the last of these run.
    placed = sorted([*_spread(waiting, 0.85), *_spread(others, 1.0)], key=itemgetter(0))
    items[:] = [item for _, file in placed for item in file]


def _tier(nodeid: str) -> str:
    """That of a test without a marker."""
    if UNIT in nodeid:
        return "unit"
    return "thorough" if nodeid.startswith(LAB) else "basic"


def _never_waits(nodeid: str) -> bool:
    return UNIT in nodeid or nodeid.startswith("tests/launch_cases/")


def _spread(
    files: list[list[pytest.Item]], end: float
) -> Iterator[tuple[float, list[pytest.Item]]]:
    """(place, file): places are spread evenly over all tests, from 0 to `end`."""
    count, before = sum(map(len, files)), 0
    for file in files:
        yield end * before / count, file
        before += len(file)


@pytest.fixture(autouse=True)
def _alone(request: pytest.FixtureRequest) -> Iterator[None]:
    """Of all test runs on the machine, one test marked `alone` at a time."""
    if request.node.get_closest_marker("alone") is None:
        yield
        return
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as lock:
        wait_until(lambda: _is_bound(lock, "\0launcher-test-alone"), "no other test alone", 500.0)
        yield


@pytest.fixture(autouse=True)
def _no_workspace_is_left() -> Iterator[None]:
    """A verb that a test calls in this process enters a workspace, which is not that of others."""
    names = ("AMENT_PREFIX_PATH", *ROS_VARIABLES)
    before = {name: os.environ[name] for name in names if name in os.environ}
    yield
    for name in names:
        os.environ.pop(name, None)
    os.environ.update(before)


def _is_bound(lock: socket.socket, name: str) -> bool:
    try:
        lock.bind(name)
    except OSError as error:
        assert error.errno == errno.EADDRINUSE
        return False
    return True


@pytest.fixture(scope="session", autouse=True)
def _environment_of_the_worker() -> Iterator[None]:
    """A ROS domain, and folders for sockets, logs and histories, that no other worker uses."""
    with (
        leased_domain() as domain_id,
        tempfile.TemporaryDirectory(prefix="t-") as folder,  # short: it holds sockets
        pytest.MonkeyPatch.context() as patch,
    ):
        patch.setenv("ROS_DOMAIN_ID", str(domain_id))
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        for name in ("GITHUB_ACTIONS", "GITHUB_STEP_SUMMARY", "GITHUB_WORKSPACE"):
            patch.delenv(name, raising=False)  # tests do not report to the workflow
        for name in ("XDG_RUNTIME_DIR", "XDG_STATE_HOME", "ROS_LOG_DIR"):
            path = Path(folder, name.lower())
            path.mkdir(mode=0o700)
            patch.setenv(name, str(path))
        yield


@pytest.fixture(scope="session", autouse=True)
def _entry_points_are_read_once() -> Iterator[None]:
    """A file in no format is given to the parsers of all distributions: finding them reads each."""
    entry_points = metadata.entry_points
    read = functools.cache(lambda path, **selection: entry_points(**selection))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(metadata, "entry_points", lambda **words: read(tuple(sys.path), **words))
        yield


@pytest.fixture(scope="session")
def fleet_workspace(tmp_path_factory: pytest.TempPathFactory) -> BuiltWorkspace:
    """`examples/fleet_workspace`, built once for all workers; tests only read it."""
    return example(tmp_path_factory.getbasetemp())
