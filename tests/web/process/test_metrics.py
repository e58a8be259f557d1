"""/metrics of a real run: who gets it, and that a scrape has the topics measured."""

from __future__ import annotations

from pathlib import Path

import pytest
from prometheus_client.parser import text_string_to_metric_families

from tests.support.repository import REPOSITORY
from tests.support.waiting import wait_until
from tests.support.web_page import get
from tests.web.process.conftest import Start

TALKER = f"""
import sys
from launch import LaunchDescription
from launch.actions import ExecuteProcess

def generate_launch_description():
    command = [sys.executable, "-m", "tests.smoke.process.talking_node", "talker"]
    return LaunchDescription([
        ExecuteProcess(cmd=command, name="talker", cwd="{REPOSITORY}", output="screen"),
    ])
"""


def samples(text: str) -> dict[tuple[str, ...], float]:
    """Name and values of labels, sorted by these -> value."""
    return {
        (one.name, *dict(sorted(one.labels.items())).values()): one.value
        for family in text_string_to_metric_families(text)
        for one in family.samples
    }


def test_metrics_need_the_token_and_the_name_of_this_machine(start: Start, sleeper: Path):
    _, link = start(sleeper)
    token = link.partition("token=")[2]
    bearer = {"Authorization": f"Bearer {token}"}
    up = ("launcher_process_up", "cat-1")  # the server learns of it when it listens already
    wait_until(lambda: up in samples(get(link, "/metrics", **bearer)[2]), "the process")
    status, headers, text = get(link, "/metrics", **bearer)
    assert status == 200
    assert headers["content-type"].startswith("text/plain; version=")
    assert headers["cache-control"] == "no-store"
    assert samples(text)[up] == 1
    assert get(link, f"/metrics?token={token}")[0] == 200
    kind = get(link, "/metrics", **bearer, Accept="application/openmetrics-text")[1]["content-type"]
    assert kind.startswith("application/openmetrics-text")
    for path, more in (
        ("/metrics", {}),
        ("/metrics?token=", {}),
        (f"/metrics?token={token}x", {}),
        ("/metrics", {"Authorization": f"Basic {token}"}),
        ("/metrics", {"Authorization": "Bearer "}),
    ):
        status, headers, text = get(link, path, **more)
        assert (status, headers["www-authenticate"]) == (401, "Bearer")
        assert token not in text
    assert get(link, "/metrics", **bearer, Host="evil.example")[0] == 403


@pytest.mark.thorough
def test_a_scrape_has_the_topics_measured(start: Start, tmp_path: Path):
    file = tmp_path / "talker.launch.py"
    file.write_text(TALKER)
    _, link = start(file)
    token = link.partition("token=")[2]

    def found() -> dict[tuple[str, ...], float]:
        return samples(get(link, f"/metrics?token={token}")[2])

    wait_until(lambda: found().get(("launcher_topic_rate_hertz", "/steady"), 0) > 0, "a rate")
    last = found()
    assert last["launcher_topic_publishers", "/steady"] == 1
    assert last["launcher_topic_bytes_per_second", "/steady"] > 0
    assert last["launcher_nodes", "running"] >= 1
    assert last["launcher_process_lines_total", "launch"] > 0
    memory = ("launcher_process_memory_bytes", "talker-1")
    wait_until(lambda: found().get(memory, 0) > 1e6, "memory")  # it is not known at once
