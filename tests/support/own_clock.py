"""A clock that can be set, for some processes: a library that changes what CLOCK_REALTIME says.

libfaketime changes the monotonic clock, too, or makes sleeps fail where it does not.
"""

from __future__ import annotations

import shutil
import struct
import subprocess
from pathlib import Path

_SOURCE = r"""
#define _GNU_SOURCE
#include <fcntl.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static const volatile long long *offset;

__attribute__((constructor)) static void begin(void) {
    const char *path = getenv("OWN_CLOCK");
    int file = path ? open(path, O_RDONLY | O_CLOEXEC) : -1;
    if (file < 0) return;
    void *map = mmap(NULL, 8, PROT_READ, MAP_SHARED, file, 0);
    close(file);
    if (map != MAP_FAILED) offset = map;
}

int clock_gettime(clockid_t clock, struct timespec *at) {
    int code = syscall(SYS_clock_gettime, clock, at);
    if (code || !offset || (clock != CLOCK_REALTIME && clock != CLOCK_REALTIME_COARSE)) return code;
    long long ns = at->tv_nsec + *offset % 1000000000;
    at->tv_sec += *offset / 1000000000;
    if (ns < 0) { ns += 1000000000; at->tv_sec--; }
    if (ns >= 1000000000) { ns -= 1000000000; at->tv_sec++; }
    at->tv_nsec = ns;
    return 0;
}

int gettimeofday(struct timeval *restrict at, void *restrict zone) {
    struct timespec now;
    (void)zone;
    clock_gettime(CLOCK_REALTIME, &now);
    at->tv_sec = now.tv_sec;
    at->tv_usec = now.tv_nsec / 1000;
    return 0;
}

time_t time(time_t *at) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    if (at) *at = now.tv_sec;
    return now.tv_sec;
}
"""


class OwnClock:
    """Processes with `variables` see this clock; RuntimeError without a C compiler."""

    def __init__(self, folder: Path) -> None:
        compiler = shutil.which("cc") or shutil.which("gcc")
        if compiler is None:
            raise RuntimeError("no C compiler")
        source, library = folder / "own_clock.c", folder / "own_clock.so"
        source.write_text(_SOURCE, encoding="ascii")
        words = [compiler, "-shared", "-fPIC", "-O2", "-o", str(library), str(source)]
        subprocess.run(words, check=True, capture_output=True)
        self._file = folder / "own_clock"
        self._file.write_bytes(bytes(8))
        self.variables = {"LD_PRELOAD": str(library), "OWN_CLOCK": str(self._file)}

    def set(self, offset_s: float) -> None:
        """Differ from the machine's clock by this."""
        with self._file.open("r+b", buffering=0) as file:
            file.write(struct.pack("q", round(offset_s * 1e9)))
