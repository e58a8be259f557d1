"""How the C library's allocator treats the memory that is freed."""

from __future__ import annotations

_M_TRIM_THRESHOLD, _M_MMAP_THRESHOLD = -1, -3  # of glibc's malloc.h
_LARGEST_BYTES = 32 << 20  # glibc takes no larger M_MMAP_THRESHOLD
_KEPT_BYTES = 128 << 20


def keep_freed_memory() -> None:
    """Use freed buffers of up to 32 MB again, and give back what is above 128 MB.

    For processes through which large buffers pass. By default glibc maps each buffer of more than
    128 kB anew, so that every page of it is a page fault and is filled with zeros: for 4 MB that
    takes longer than writing them into a file (mallopt(3)). Without effect where the C library has
    no such setting.
    """
    import ctypes

    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(_M_MMAP_THRESHOLD, _LARGEST_BYTES)
        mallopt(_M_TRIM_THRESHOLD, _KEPT_BYTES)
