"""What listens before there is a publisher gets all that the publisher sends."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator, Mapping

import pytest

from launcher.posix.ports import participants_by_domain
from launcher.ros.discovery.observer import Observer
from launcher.ros.snapshot.ros_graph import Direction
from tests.support.foxglove_client import connected
from tests.support.foxglove_server import serving
from tests.support.ros_domain import ros_domain
from tests.support.verbs import going_on, launcher
from tests.support.waiting import wait_until

STRING = "std_msgs/msg/String"
KEPT = ("--qos-durability", "transient_local")
WEAK = ("--qos-reliability", "best_effort")


@pytest.fixture
def env(tmp_path) -> Iterator[dict[str, str]]:
    with ros_domain(tmp_path) as env:
        yield env


@pytest.fixture
def observer(env: dict[str, str]) -> Iterator[Observer]:
    with Observer(int(env["ROS_DOMAIN_ID"])) as observer:
        yield observer


def publish(env: Mapping[str, str], text: str, *policies: str) -> None:
    answer = launcher(env, "topic", "pub", "/t", STRING, f"data: {text}", "--once", *policies)
    assert answer.code == 0, answer


def await_end_of_weak(observer: Observer) -> None:
    """The next publisher shall find no BEST_EFFORT subscription."""

    def is_over() -> bool:
        infos = observer.infos("/t", Direction.SUBSCRIPTION)
        return not any(info.reliability == "BEST_EFFORT" for info in infos)

    wait_until(is_over, "the BEST_EFFORT subscription has ended")


@contextlib.contextmanager
def lines_of(env: Mapping[str, str], *words: str) -> Iterator[list[str]]:
    """The lines that a verb prints; it has a participant."""
    domain_id = int(env["ROS_DOMAIN_ID"])
    before = participants_by_domain()[domain_id]
    lines: list[str] = []
    with going_on({**env, "PYTHONUNBUFFERED": "1"}, *words) as program:
        assert program.stdout is not None
        pipe = program.stdout
        reader = threading.Thread(target=lambda: lines.extend(map(str.strip, pipe)))
        reader.start()
        wait_until(lambda: participants_by_domain()[domain_id] > before, "it has a participant")
        yield lines
        program.terminate()
        reader.join()


@pytest.mark.parametrize("policies", [KEPT, ()], ids=["kept", "volatile"])
def test_echo_that_was_first_gets_what_is_published_once(env: dict[str, str], policies):
    with lines_of(env, "topic", "echo", "/t", STRING, "--csv") as lines:
        publish(env, "first", *policies)
        wait_until(lambda: "first" in lines, "the message")
    assert lines.count("first") == 1


@pytest.mark.thorough
def test_echo_fits_one_publisher_after_the_other(env: dict[str, str], observer: Observer):
    with lines_of(env, "topic", "echo", "/t", STRING, "--csv") as lines:
        for number in range(3):
            publish(env, f"kept {number}", *KEPT)
            publish(env, f"weak {number}", *WEAK)
            await_end_of_weak(observer)
        kept = [f"kept {number}" for number in range(3)]
        wait_until(lambda: set(kept) <= set(lines), "all that are not lost")
    assert [line for line in lines if line in kept] == kept


@pytest.mark.thorough
def test_a_recorder_fits_one_publisher_after_the_other(
    env: dict[str, str], observer: Observer, tmp_path
):
    bag = tmp_path / "bag"
    with going_on(env, "bag", "record", "/t", "-o", str(bag)):
        for number in range(3):
            publish(env, f"weak {number}", *WEAK)
            await_end_of_weak(observer)
            publish(env, f"kept {number}", *KEPT)
    rows = launcher(env, "bag", "convert", str(bag), "-o", "-", "--to", "csv").out
    assert [rows.count(f"kept {number}") for number in range(3)] == [1, 1, 1], rows


@pytest.mark.thorough
def test_a_client_of_foxglove_gets_what_is_published_once(env: dict[str, str]):
    asked = ("--qos-reliability", "best_effort")  # what makes the topic exist
    with (
        serving(env) as server,
        connected(server.url) as client,
        going_on(env, "topic", "echo", "/t", STRING, *asked),
    ):
        received = client.subscribe("/t")
        for number in range(3):
            publish(env, f"{number}", *KEPT, "-w", "2")
            client.wait(lambda count=number + 1: len(received.messages) >= count, "the message")
        assert [message.data for message in received.decoded()] == ["0", "1", "2"]


@pytest.mark.thorough
def test_a_measurement_that_was_first_sees_all(env: dict[str, str]):
    with lines_of(env, "topic", "bw", "/t") as lines:
        words = ("topic", "pub", "/t", STRING, "--times", "3", "--rate", "1", *KEPT)
        assert launcher(env, *words).code == 0
        wait_until(lambda: any("B/s from 3 messages" in line for line in lines), "a report")
