"""How the C library's allocator treats the memory that is freed."""

from __future__ import annotations

import contextlib

# glibc learns from blocks of at most 32 MiB, with what it adds to each.
LARGEST_BYTES = (32 << 20) - (64 << 10)


def keep_freed_memory(largest_bytes: int = LARGEST_BYTES) -> None:
    """Use freed buffers of up to `largest_bytes` again, and give back what is above twice as much.

    For processes through which large buffers pass. By default glibc maps each buffer of more than
    128 KiB anew, so that every page of it is a page fault and is filled with zeros, and returns
    free memory from the same size on: that takes longer than what else is done with a buffer.
    When a larger one is freed, it raises both limits (M_MMAP_THRESHOLD in mallopt(3)). Without
    effect with other C libraries, and where the environment sets the limits.
    """
    with contextlib.suppress(MemoryError):
        bytes(largest_bytes)  # mapped, never touched, and unmapped
