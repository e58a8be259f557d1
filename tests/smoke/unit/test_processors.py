"""How many processors may be kept busy, and that those who do so wait for each other."""

from __future__ import annotations

import os
import select
import signal

import pytest

from launcher.base.document.fields import FieldError
from launcher.base.errors import LauncherError
from launcher.smoke.inject import processors, stress
from launcher.smoke.inject.chaos_plan import parse
from launcher.smoke.inject.grammar import parsed


def test_more_than_a_few_for_each_processor_are_refused(monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda pid: {4, 6})
    assert parsed("cpu 32").value("cores") == 32
    says = "33 are more than 32, 16 for each processor that may be used"
    with pytest.raises(FieldError, match=f"cpu: {says}"):
        parsed("cpu 33")
    with pytest.raises(LauncherError, match=says):
        parse("{every: 1 s, injections: [{inject: machine cpu 33}]}", "a")
    request = {"pid": None, "cores": 33, "kind": "cpu", "for_s": 5.0}
    with pytest.raises(stress.StressRefusedError, match=says):
        stress.cpu(request, stress.StressInput(5.0))
    assert processors.excess(32, 2) == ""


def test_burners_wait_until_all_are_there():
    waiting, begin = os.pipe()
    burner = stress._burner(waiting, begin)
    descriptor = os.pidfd_open(burner)
    try:
        assert not select.select([descriptor], [], [], 0.1)[0]
        assert _cpu_ticks(burner) <= 2
        os.close(begin)
        while _cpu_ticks(burner) <= 2:
            assert not select.select([descriptor], [], [], 0.01)[0]
    finally:
        os.kill(burner, signal.SIGKILL)
        os.waitpid(burner, 0)
        os.close(descriptor)
        os.close(waiting)


def test_burners_are_not_made_after_the_end(monkeypatch):
    made: list[int] = []
    monkeypatch.setattr(stress, "_burner", lambda waiting, begin: made.append(1))
    monkeypatch.setattr(stress, "ready", lambda: pytest.fail("it was over before"))
    stress.cpu({"pid": None, "cores": 2}, stress.StressInput(-stress.SPARE_S))
    assert made == []


def _cpu_ticks(pid: int) -> int:
    with open(f"/proc/{pid}/stat", encoding="utf-8") as file:
        fields = file.read().rpartition(")")[2].split()
    return int(fields[11]) + int(fields[12])
