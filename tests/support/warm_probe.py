"""Writes all that a process can see of how it was started, as JSON, to the file in argv[1].

Values that differ between any two processes are replaced by what they should be.
"""

from __future__ import annotations

import atexit
import contextlib
import ctypes
import faulthandler
import fcntl
import gc
import inspect
import json
import locale
import logging
import os
import random
import resource
import signal
import sys
import tempfile
import threading
import time
import uuid
import warnings

_STATUS = ("Name", "Umask", "SigBlk", "SigIgn", "SigCgt", "Threads", "Uid", "Gid", "Groups",
           "NoNewPrivs", "CapEff", "Seccomp", "Cpus_allowed")  # fmt: skip
# glibc ignores its two internal signals in what posix_spawn starts, and nowhere else.
_OF_GLIBC = 0b11 << 31


def process_facts() -> dict:
    mask = os.umask(0)
    os.umask(mask)
    return {
        "leads": [os.getpgrp() == os.getpid(), os.getsid(0) == os.getpid()],
        "parent": os.getppid() == int(os.environ["LAUNCHER_RUN_ID"].partition("-")[0]),
        "folder": os.getcwd(),
        "umask": mask,
        "rlimits": [resource.getrlimit(number) for number in range(16)],
        "nice": os.getpriority(os.PRIO_PROCESS, 0),
        "cpus": sorted(os.sched_getaffinity(0)),
        "scheduler": os.sched_getscheduler(0),
        "oom": _read("oom_score_adj"),
        "personality": _read("personality"),
        "status": _status(),
        "command": _read("cmdline"),
        "environment": _read("environ"),
        "name": _read("comm"),
        "program": os.readlink("/proc/self/exe"),
        "descriptors": _descriptors(),
        "terminal": [os.isatty(number) for number in range(3)],
        "size": os.get_terminal_size(1) if os.isatty(1) else None,
        "controlling": _controlling_terminal(),
        "young": time.process_time() < 5 and time.time() - _started() < 30,
    }


def _read(name: str) -> str:
    with open(f"/proc/self/{name}", encoding="utf-8", errors="surrogateescape") as file:
        return file.read()


def _status() -> dict:
    lines = dict(line.split(":\t", 1) for line in _read("status").splitlines() if ":\t" in line)
    facts = {name: lines.get(name) for name in _STATUS}
    facts["SigIgn"] = hex(int(facts["SigIgn"] or "0", 16) & ~_OF_GLIBC)
    return facts


def _descriptors() -> dict:
    found = {}
    for name in os.listdir("/proc/self/fd"):
        with contextlib.suppress(OSError):
            kind = os.readlink(f"/proc/self/fd/{name}").partition(":")[0]
            flags = fcntl.fcntl(int(name), fcntl.F_GETFL), os.get_inheritable(int(name))
            found[name] = "pts" if "/dev/pts" in kind else kind, *flags
    return found


def _controlling_terminal() -> bool:
    try:
        os.close(os.open("/dev/tty", os.O_RDWR))
    except OSError:
        return False
    return True


def _started() -> float:
    ticks = int(_read("stat").rpartition(")")[2].split()[19])
    with open("/proc/uptime") as file:
        return time.time() - float(file.read().split()[0]) + ticks / os.sysconf("SC_CLK_TCK")


def python_facts() -> dict:
    main = vars(sys.modules["__main__"])
    libc = ctypes.CDLL(None)
    libc.getenv.restype = ctypes.c_char_p
    return {
        "argv": sys.argv,
        "orig_argv": sys.orig_argv,
        "path": sys.path,
        "flags": repr(sys.flags),
        "executable": [sys.executable, sys.prefix, sys.base_prefix, sys.exec_prefix],
        "main": {k: repr(v).partition(" object at ")[0] for k, v in main.items() if k[:2] == "__"},
        "main_names": list(main),
        "variables": dict(os.environ),
        "variables_in_c": {k: str(libc.getenv(k.encode())) for k in os.environ},
        "signals": {int(s): repr(signal.getsignal(s)) for s in signal.valid_signals()},
        "streams": [*map(_stream, ("stdin", "stdout", "stderr"))],
        "threads": [threading.active_count(), repr(threading.current_thread().name)],
        "main_thread": threading.main_thread().native_id == os.getpid(),
        "garbage": [gc.isenabled(), gc.get_threshold()],
        "faulthandler": faulthandler.is_enabled(),
        "locale": [locale.setlocale(locale.LC_ALL), sys.getfilesystemencoding(), time.tzname],
        "hooks": [sys.excepthook is sys.__excepthook__, sys.gettrace(), len(sys.path_hooks)],
        "finders": [getattr(one, "__name__", type(one).__name__) for one in sys.meta_path],
        "limits": [sys.getrecursionlimit(), sys.getswitchinterval(), sys.dont_write_bytecode],
        "warnings": [repr(warnings.filters), sys.warnoptions, dict(sys._xoptions)],
        "ours": [name for name in sys.modules if name.partition(".")[0] == "launcher"],
        "fresh": [tempfile._name_sequence is None, _log_age_s() < 30],
        "frames": [frame.function for frame in inspect.stack()][:3],  # below is what runs it
    }


def _log_age_s() -> float:
    began = logging._startTime
    return time.time() - (began / 1e9 if isinstance(began, int) else began)


def _stream(name: str) -> list:
    stream = getattr(sys, name)
    return [
        repr(stream),
        stream is getattr(sys, f"__{name}__"),
        *(stream.encoding, stream.errors, stream.line_buffering, stream.write_through),
        *(repr(type(stream.buffer)), stream.isatty(), stream.fileno(), stream.closed),
    ]


def main() -> int:
    facts = {**process_facts(), **python_facts()}
    with open(sys.argv[1], "w", encoding="utf-8", errors="surrogateescape") as file:
        json.dump(facts, file, default=repr)
    print("random:", random.random(), random.SystemRandom().random(), uuid.uuid1(), uuid.uuid4())
    atexit.register(print, "at exit")
    return 7


if __name__ == "__main__":
    sys.exit(main())
