"""What `stress` refuses, and the file with which it fills a disk."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from launcher.smoke.inject import stress


class Endless(stress.StressInput):
    """An input that stays open, whatever that of the tests is."""

    def is_over(self, wait_s: float = 0.0, *more: int) -> bool:
        return False


def test_memory_that_is_not_there_is_refused():
    stress.refuse_memory(1 << 20, "memory")
    with pytest.raises(stress.StressRefusedError, match="would make the kernel kill processes"):
        stress.refuse_memory(1 << 50, "memory")


def test_a_disk_is_filled_by_a_file_without_a_name(tmp_path: Path, monkeypatch):
    descriptor = stress._nameless_file(str(tmp_path))
    room = 3 << 20
    monkeypatch.setattr(
        stress, "_free", lambda file: room - os.fstat(file).st_blocks // 8 * stress.BLOCK_BYTES
    )
    size = stress._grow(descriptor, 0, 1 << 20, Endless(60.0))
    facts = os.fstat(descriptor)
    assert (size, facts.st_size, facts.st_nlink) == (2 << 20, 2 << 20, 0)
    assert list(tmp_path.iterdir()) == []
    os.close(descriptor)
