"""Metrics of made-up feeds, read with Prometheus' own parser."""

from __future__ import annotations

from typing import Any

from prometheus_client.openmetrics.parser import (
    text_string_to_metric_families as open_metrics_families,
)
from prometheus_client.parser import text_string_to_metric_families

from launcher.web.fault_feed import FaultFeed
from launcher.web.hub import Hub
from launcher.web.log_store import LogStore
from launcher.web.metrics import DEFINITIONS, Metrics
from tests.support.watcher_stand_in import fault

HOSTILE = 'a"b\\c\nd{e="f"} 1'


class Feed:
    """As RunFeed and GraphFeed, with what a test sets."""

    def __init__(self, **more: Any) -> None:
        self.run = {"id": "1-a", "target": "/x.launch.py", "domain_id": 3, "started_wall_s": 1000.5}
        self.launcher = "0.1.0"
        self.rows: list[dict[str, Any]] = []
        self.log = LogStore()
        self.expectations: dict[str, Any] | None = None
        self.faults = FaultFeed(Hub(lambda: None))
        self.graph: dict[str, Any] | None = None
        self.traffic: dict[str, dict[str, Any]] = {}
        for name, value in more.items():
            setattr(self, name, value)


def row(name: str, **more: Any) -> dict[str, Any]:
    given = {"state": "RUNNING", "pid": 5, "restarts": 2, "uptime_s": 3.5, "cpu_percent": 150.0}
    return {"name": name, **given, "uss_bytes": 1024, "rss_bytes": 4096, **more}


def scraped(**more: Any) -> dict[tuple[str, ...], float]:
    """The samples of a scrape: name and values of labels, sorted by these -> value."""
    feed = Feed(**more)
    text, kind = Metrics(feed, feed).text("text/plain")
    assert kind.startswith("text/plain")
    return {
        (sample.name, *dict(sorted(sample.labels.items())).values()): sample.value
        for family in text_string_to_metric_families(text.decode())
        for sample in family.samples
    }


def test_a_run_without_anything_has_its_info():
    found = scraped()
    assert found["launcher_run_info", "3", "1-a", "/x.launch.py", "0.1.0"] == 1
    assert found["launcher_run_start_time_seconds",] == 1000.5
    assert not [key for key in found if key[0].startswith("launcher_process")]


def test_processes():
    gone = row("b-2", state="FATAL", pid=None, cpu_percent=None, uss_bytes=None, uptime_s=None)
    found = scraped(rows=[row("a-1"), gone])
    assert (found["launcher_process_up", "a-1"], found["launcher_process_up", "b-2"]) == (1, 0)
    assert found["launcher_process_cpu_ratio", "a-1"] == 1.5
    assert found["launcher_process_memory_bytes", "a-1"] == 1024
    assert found["launcher_process_restarts_total", "a-1"] == 2
    assert found["launcher_process_state", "b-2", "FATAL"] == 1
    assert found["launcher_process_state", "b-2", "RUNNING"] == 0
    assert ("launcher_process_cpu_ratio", "b-2") not in found


def test_lines_by_process_and_level():
    log = LogStore()
    for text in ("one", "[ERROR] two"):
        log.add({"process": "a-1", "stream": "stdout", "wall_s": 1.0, "text": text})
    log.add({"process": None, "stream": "stderr", "wall_s": 1.0, "text": "launcher"})
    log.add({"dropped": 7, "processes": {"a-1": 7}})
    found = scraped(log=log)
    assert found["launcher_process_lines_total", "a-1"] == 9
    assert found["launcher_log_lines_total", "ERROR", "a-1"] == 1
    assert found["launcher_log_lines_total", "INFO", "launch"] == 1
    assert found["launcher_lines_skipped_total",] == 7


def test_topics():
    topic = {"name": "/t", "publishers": 2, "subscriptions": 1}
    nodes = [{"state": "running"}, {"state": "gone"}, {"state": "running", "hidden": True}]
    graph = {"nodes": nodes, "topics": [topic], "mismatches": [{"topic": "/t"}]}
    one = {"rate_hz": 2.5, "bytes_per_s": 10.0, "age_s": None, "count": 9}
    found = scraped(graph=graph, traffic={"/t": one})
    assert found["launcher_nodes", "running"] == found["launcher_nodes", "gone"] == 1
    assert found["launcher_topic_publishers", "/t"] == 2
    assert found["launcher_topic_mismatches", "/t"] == 1
    assert found["launcher_topic_rate_hertz", "/t"] == 2.5
    assert found["launcher_topic_messages_total", "/t"] == 9
    assert ("launcher_topic_age_seconds", "/t") not in found


def test_expectations_by_state():
    items = [{"state": "passed"}, {"state": "passed"}, {"state": "open"}]
    found = scraped(expectations={"items": items})
    counts = [found["launcher_expectations", state] for state in ("passed", "open", "failed")]
    assert counts == [2, 1, 0]


def test_faults_of_a_watched_run_by_state_and_by_name():
    assert not [key for key in scraped() if key[0].startswith("launcher_fault")]
    feed = FaultFeed(Hub(lambda: None))
    faults = [fault("a", count=2, expectation="e"), fault("b", state="healed"), fault(HOSTILE)]
    feed.known = {one["fault"]: one for one in faults}
    found = scraped(faults=feed)
    counts = [found["launcher_faults", state] for state in ("suspected", "active", "healed")]
    assert counts == [0, 2, 1]
    assert found["launcher_fault_active", "e", "a"] == 1
    assert found["launcher_fault_active", "b", "b"] == 0
    assert found["launcher_faults_confirmed_total", "a"] == 2
    assert found["launcher_faults_confirmed_total", HOSTILE] == 1


def test_names_are_labels_whatever_they_are():
    found = scraped(rows=[row(HOSTILE), row("\udcff")], traffic={HOSTILE: {"rate_hz": 1.0}})
    assert found["launcher_process_up", HOSTILE] == 1
    assert found["launcher_process_up", "?"] == 1
    assert found["launcher_topic_rate_hertz", HOSTILE] == 1


def test_both_formats_have_every_metric_with_its_help():
    feed = Feed()
    text, _ = Metrics(feed, feed).text("text/plain")
    families = {one.name: one for one in text_string_to_metric_families(text.decode())}
    modern, kind = Metrics(feed, feed).text("application/openmetrics-text; version=1.0.0")
    assert kind.startswith("application/openmetrics-text")
    names = {one.name for one in open_metrics_families(modern.decode())}
    for definition in DEFINITIONS:
        name = definition.name.removesuffix("_total")
        assert families[name].documentation == definition.help
        assert name in names
        assert (families[name].type == "counter") == (name != definition.name)
