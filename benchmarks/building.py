"""`launcher build`: a package of messages with each compiler, and ten packages unchanged."""

from __future__ import annotations

import shutil
from pathlib import Path

from benchmarks.contestant import python_s
from benchmarks.harness import Row, interleaved, median, ratio, scratch
from tests.workspace.process.building.small_packages import (
    files_package,
    message_package,
    python_package,
)

SYSTEM_S, ZIG_S, UNCHANGED_S = 15.0, 30.0, 2.0


def building(runs: int) -> list[Row]:
    """With the compilers' caches filled: the first turn of `interleaved` does not count."""
    with scratch() as folder:
        one, ten = Path(folder) / "one", Path(folder) / "ten"
        message_package(one / "src", "messages", "msg/Number.msg", "srv/Add.srv")
        (one / "src/messages/srv/Add.srv").write_text("int64 a\nint64 b\n---\nint64 sum\n")
        _ten_packages(ten / "src")
        _build(ten)
        found = interleaved(
            runs,
            {
                "gcc": lambda: _afresh(one, "gcc"),
                "zig": lambda: _afresh(one, "zig"),
                "unchanged": lambda: _build(ten),
                "bare": lambda: python_s("-c", "pass"),
            },
        )
    start = f"{ratio(found['unchanged'], found['bare']):.1f} x python -c pass"
    return [
        Row("build a message and a service, gcc", median(found["gcc"]), "s", SYSTEM_S, ""),
        Row("the same, zig", median(found["zig"]), "s", ZIG_S, "its C++ library is cached"),
        Row("ten packages, unchanged", median(found["unchanged"]), "s", UNCHANGED_S, start),
    ]


def _ten_packages(src: Path) -> None:
    message_package(src, "messages")
    for number in range(5):
        python_package(src, f"nodes_{number}", "messages")
    for number in range(4):
        files_package(src, f"files_{number}")


def _afresh(root: Path, compiler: str) -> float:
    for name in ("build", "install", "log"):
        shutil.rmtree(root / name, ignore_errors=True)
    return _build(root, "--compiler", compiler)


def _build(root: Path, *words: str) -> float:
    return python_s("-m", "launcher", "build", *words, folder=root)
