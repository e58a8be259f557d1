"""Signals that end a build."""

from __future__ import annotations

import signal

import pytest

from launcher.workspace.building.colcon import build_signals


def test_sighup_ends_a_build_unless_it_is_ignored_as_by_nohup():
    with pytest.raises(build_signals.BuildTerminated), build_signals.end_the_build():
        signal.raise_signal(signal.SIGHUP)

    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with build_signals.end_the_build():
            signal.raise_signal(signal.SIGHUP)
    finally:
        signal.signal(signal.SIGHUP, before)
