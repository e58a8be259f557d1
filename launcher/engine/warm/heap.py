"""Keeps pages of the C heap shared between the preparing process and those that it forks.

Imports leave gaps all over the heap. A forked process that allocates in one writes to its page,
and so gets a copy of the page. With the gaps taken before the fork, it allocates in few new pages
instead: 1 MB less per node.
"""

from __future__ import annotations

import ctypes

_STEP = 16  # bytes; malloc of glibc rounds sizes up to multiples
_LARGEST = 4096  # bytes; where a gap is larger, at most two of its pages are shared with others
_ABOVE = 65536  # bytes; larger than a gap usually is, so that it lies above them
_MOST = 20_000  # gaps; for an allocator in place of glibc's, whose addresses do not grow


def fill_gaps() -> None:
    """Allocate the gaps, for good. Without effect where the C library is not glibc."""
    libc = ctypes.CDLL(None)
    if not hasattr(libc, "malloc_trim"):
        return
    libc.malloc.restype = ctypes.c_void_p
    libc.malloc.argtypes = [ctypes.c_size_t]
    libc.free.argtypes = [ctypes.c_void_p]
    top = libc.malloc(_ABOVE) or 0
    libc.free(top)
    left = _MOST
    for size in range(_LARGEST, 0, -_STEP):
        while (address := libc.malloc(size)) and address < top and left:
            left -= 1
        libc.free(address)
    libc.malloc_trim(0)
