"""A ROS domain with publishers that the tests of the ROS verbs share."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping

import pytest

from launcher.posix.domain_lease import leased_domain
from launcher.posix.ports import participants_by_domain
from launcher.ros.discovery.observer import Observer
from tests.support.node_process import free_shared_memory, shared_memory_of
from tests.support.repository import REPOSITORY
from tests.support.verbs import Answer, in_process
from tests.support.waiting import wait_until

Verb = Callable[..., Answer]


@contextlib.contextmanager
def ros_domain(log_dir: object) -> Iterator[dict[str, str]]:
    """The environment of a separate domain."""
    with leased_domain() as domain_id:
        yield {
            **os.environ,
            "ROS_DOMAIN_ID": str(domain_id),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_LOG_DIR": str(log_dir),
        }


@contextlib.contextmanager
def talking(env: dict[str, str], module: str, *words: str) -> Iterator[subprocess.Popen[str]]:
    """A helper program of tests.support that runs until its stdin is closed."""
    program = subprocess.Popen(
        [sys.executable, "-m", module, *words],
        env=env,
        cwd=REPOSITORY,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert program.stdout is not None
        # Fast DDS may complain first, on standard output: of a port that another process closes.
        assert "ready\n" in iter(program.stdout.readline, "")
        yield program
    finally:
        left_over = shared_memory_of(program.pid)
        with contextlib.suppress(BrokenPipeError):
            program.communicate(timeout=60)
        if program.returncode < 0:  # killed: nobody else removes what it held
            free_shared_memory(left_over)


@pytest.fixture(scope="session")
def env(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    """The shared domain, with the sample nodes in it."""
    with (
        ros_domain(tmp_path_factory.mktemp("ros_log")) as env,
        talking(env, "tests.support.sample_nodes"),
    ):
        yield env


def patient_verb(env: Mapping[str, str], monkeypatch: pytest.MonkeyPatch) -> Verb:
    """Runs commands in this process and in a domain, and waits long for nodes."""
    for name in ("ROS_DOMAIN_ID", "ROS_LOG_DIR"):
        monkeypatch.setenv(name, env[name])
    # The sample nodes may be kept from answering for longer than a person would wait.
    for limit in (
        "launcher.posix.domains.SPIN_TIME_S",
        "launcher.ros.service_caller.ANSWER_S",
        "launcher.ros.service_caller._CONNECT_S",
        "launcher.ros.service_caller._PREFETCHED_S",
        "launcher.ros.verbs.service._CONNECT_S",
    ):
        monkeypatch.setattr(limit, 60.0)
    return in_process


@pytest.fixture
def verb(env: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> Verb:
    """`verb("topic", "list")` runs that command in the shared domain."""
    return patient_verb(env, monkeypatch)


@pytest.fixture(scope="session")
def empty_domain(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    """A domain without nodes."""
    with ros_domain(tmp_path_factory.mktemp("empty_log")) as env:
        yield env


@pytest.fixture
def observer(env: dict[str, str]) -> Iterator[Observer]:
    """An observer of the shared domain that has discovered every participant."""
    domain_id = int(env["ROS_DOMAIN_ID"])
    with Observer(domain_id) as observer:
        wait_until(
            lambda: len(observer.participants()) >= participants_by_domain()[domain_id],
            "every participant is known",
        )
        yield observer
