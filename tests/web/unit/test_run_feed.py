"""What comes of the control socket."""

from __future__ import annotations

import asyncio
from typing import Any

from launcher.web.fault_feed import FaultFeed
from launcher.web.hub import Hub
from launcher.web.run_feed import RunFeed
from tests.support.watcher_stand_in import fault


def test_faults_are_sent_together_and_a_suspicion_that_was_none_is_gone():
    sent: list[dict[str, Any]] = []
    hub = Hub(lambda: None)
    hub.send = sent.append  # type: ignore[method-assign]

    async def run() -> None:
        feed = FaultFeed(hub)
        feed.take({**fault("early"), "change": "present"})
        feed.known = {}
        for name, change, count in (("a", "confirmed", 1), ("b", "suspected", 0)):
            feed.take({**fault(name, count=count), "change": change})
        feed.take({"dropped": 3})
        feed.take({**fault("b", count=0), "change": "dismissed"})
        feed.take({**fault("c", count=1, state="healed"), "change": "dismissed"})
        feed.flush()
        feed.flush()
        assert [one["fault"] for one in feed.opening()[0]["items"]] == ["a", "c"]

    asyncio.run(run())
    (message,) = sent
    assert [one["fault"] for one in message["items"]] == ["a", "c"]
    assert (message["gone"], message["reset"]) == (["b"], False)


def test_that_items_were_dropped_ends_nothing():
    feed = RunFeed(Hub(lambda: None), lambda: None)
    feed._requests.hello = {"run": {"log_dir": None}}
    rows = [{"name": "a-1", "cpu_percent": 1.0, "uss_bytes": 5, "pid": 7, "state": "RUNNING"}]
    feed._take_processes({"processes": rows})
    feed._take_processes({"dropped": 2})
    assert feed.rows == rows
