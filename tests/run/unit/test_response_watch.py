"""How long nodes are asked whether they answer, by hand: nothing is started."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from launcher.run.monitor.responsiveness import LOOK_S, Responsiveness
from launcher.run.processes.machine_events import ProcessState
from launcher.run.processes.process import Silence


def silent() -> Any:
    """A process that does not respond."""
    machine = SimpleNamespace(state=ProcessState.RUNNING, is_suspended=False)
    return SimpleNamespace(
        name="node-1",
        child=SimpleNamespace(pid=7),
        machine=machine,
        debugger=None,
        host=None,
        spec=SimpleNamespace(argv=["node"], env={}),
        answers=True,
        silence=Silence(),
    )


@pytest.mark.parametrize(("is_watched", "goes_on"), [(True, True), (False, False)])
def test_a_watched_run_asks_a_node_until_it_answers(
    is_watched: bool, goes_on: bool, monkeypatch: pytest.MonkeyPatch
):
    process, now_s = silent(), [100.0]
    monkeypatch.setattr(Responsiveness, "_wanted", lambda part: {"0": {"/node": process}})
    monkeypatch.setattr(Responsiveness, "_started", lambda part, domain, env: None)
    run = SimpleNamespace(
        reactor=SimpleNamespace(
            now=lambda: now_s[0],
            call_later=lambda *given: SimpleNamespace(cancel=lambda: None),
        ),
        log=None,
        all_processes={1: process},
        options=SimpleNamespace(watchful=is_watched, expect=None),
    )
    part = Responsiveness(cast("Any", run))
    part.look()
    now_s[0] += LOOK_S + 1.0
    part._tick()
    assert (process.silence is not None) is goes_on
    process.silence = None
    part._tick()
    assert part._timer is None
