"""What comes of the control socket."""

from __future__ import annotations

from launcher.web.hub import Hub
from launcher.web.run_feed import RunFeed


def test_that_items_were_dropped_ends_nothing():
    feed = RunFeed(Hub(lambda: None), lambda: None)
    feed._requests.hello = {"run": {"log_dir": None}}
    rows = [{"name": "a-1", "cpu_percent": 1.0, "uss_bytes": 5, "pid": 7, "state": "RUNNING"}]
    feed._take_processes({"processes": rows})
    feed._take_processes({"dropped": 2})
    assert feed.rows == rows
