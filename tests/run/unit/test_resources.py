"""Sums of resource samples over a process tree."""

from __future__ import annotations

import pytest

from launcher.run.monitor.resources import Reading, summed


def reading(cpu_s: float = 0.0, uss_bytes: int | None = 10) -> Reading:
    return Reading(cpu_s=cpu_s, rss_bytes=30, uss_bytes=uss_bytes, threads=2, fds=5)


def test_a_tree_is_the_sum_of_its_members():
    sample = summed(7, [reading(cpu_s=1.0), reading(cpu_s=0.5, uss_bytes=1)], elapsed_s=2.0)
    assert (sample.pid, sample.processes, sample.threads, sample.fds) == (7, 2, 4, 10)
    assert (sample.rss_bytes, sample.uss_bytes, sample.cpu_percent) == (60, 11, 75.0)


def test_the_uss_is_not_known_before_it_is_known_of_every_member():
    assert summed(7, [reading(), reading(uss_bytes=None)], elapsed_s=1.0).uss_bytes is None


@pytest.mark.parametrize("elapsed_s", [0.0, -1.0])
def test_cpu_load_needs_elapsed_time(elapsed_s: float):
    assert summed(7, [reading(cpu_s=1.0)], elapsed_s).cpu_percent is None
