"""Keeps pages of the C heap shared between the preparing process and those that it forks.

Imports leave gaps all over the heap. A forked process that allocates in one writes to its page,
and so gets a copy of the page. With the gaps taken before the fork, it allocates in few new pages
instead: 1 MB less per node.
"""

from __future__ import annotations

import ctypes

# Bytes. Large gaps are taken in few pieces, since each piece writes to one page; malloc of glibc
# rounds small sizes up to multiples of 16.
_SIZES = (65536, 32768, 16384, 8192, *range(4096, 0, -16))


def fill_gaps() -> None:
    """Allocate all gaps and never free them. Without effect where the C library is not glibc."""
    libc = ctypes.CDLL(None)
    if not hasattr(libc, "malloc_trim"):
        return
    libc.malloc.restype = libc.sbrk.restype = ctypes.c_void_p
    libc.malloc.argtypes = [ctypes.c_size_t]
    libc.sbrk.argtypes = [ctypes.c_ssize_t]
    libc.free.argtypes = [ctypes.c_void_p]
    libc.malloc_trim(0)  # the heap ends with its last allocation, and pages of gaps are released
    end = libc.sbrk(0)  # other allocators and mappings are above it
    for size in _SIZES:
        while (address := libc.malloc(size)) and address < end:
            pass
        libc.free(address)
