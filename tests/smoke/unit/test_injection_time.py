"""From when on the time of an injection counts."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from launcher.smoke.inject import injections
from launcher.smoke.inject.effects import Effect, Report, StressEffect
from launcher.smoke.inject.grammar import parsed


class SlowlyBeginning(Effect):
    """One that can be seen at once, and is never in force; it ends as one that could not begin."""

    counts_beginning = True

    def begin(self, acts: Callable[[], None], done: Report) -> None:
        self._done = done
        acts()

    def end(self, done: Callable[[], None]) -> None:
        self._done("it was over before it was in force")
        done()


def test_the_time_of_one_that_begins_slowly_is_limited(monkeypatch: pytest.MonkeyPatch):
    due: dict[float, Callable[[], Any]] = {}
    timer = SimpleNamespace(cancel=lambda: None)
    run: Any = SimpleNamespace(
        reactor=SimpleNamespace(
            now=lambda: 100.0, call_later=lambda s, call: due.update({s: call}) or timer
        ),
        shutdown=SimpleNamespace(has_begun=False),
        log=SimpleNamespace(log=lambda *words: None, note=lambda *words: None),
    )
    monkeypatch.setattr(injections, "load", lambda path: SlowlyBeginning)
    part, problems = injections.Injections(run), []
    one = part.begin_one(parsed("memory 1M for 7 s"), None, problems.append)
    assert (one.until_s, problems) == (107.0, [])
    due[7.0]()
    assert problems == ["it was over before it was in force"]
    assert part.active == []


def test_the_first_effect_and_what_is_in_force_differ():
    effect, calls = StressEffect(SimpleNamespace(), parsed("memory 1M"), None), []  # type: ignore[arg-type]
    effect.acts = lambda: calls.append("acts")
    effect._done = calls.append
    effect.heard({"begins": True})
    assert calls == ["acts"]
    effect.heard({"ready": True})
    assert calls == ["acts", None]
