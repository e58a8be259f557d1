"""Runs the verbs of `bag` on mutated bags: `python -m tests.fuzz.bags.worker SEEDS FOLDER`.

Reads a kind and a number from each line, and writes a line of JSON: the outcomes of all verbs.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import resource
import shutil
import sys
import traceback
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import launcher.bag.ros.player as play_module
from launcher.cli.dispatch import main
from launcher.ros.snapshot.ros_graph import GraphSnapshot
from tests.fuzz.bags.mutations import mutate
from tests.fuzz.bags.seeds import mutable

MEMORY_BYTES = 300 << 20
# Of a verb: words, with BAG for the mutated bag, GOOD for the whole one and OUT for a new place.
VERBS = {
    "info": ("info", "BAG"),
    "info -v": ("info", "BAG", "-v"),
    "info --json": ("info", "BAG", "-v", "--json"),
    "play": ("play", "BAG", "-r", "1e18", "--clock", "--disable-keyboard-controls"),
    "convert bag": ("convert", "BAG", "-o", "OUT"),
    "convert mcap": ("convert", "BAG", "-o", "OUT.mcap", "--start", "0.3", "--topics", "/text"),
    "convert csv": ("convert", "BAG", "-o", "OUT.csv", "--topics", "/text"),
    "convert jsonl": ("convert", "BAG", "-o", "OUT.jsonl", "--exclude-topics", "/s/_service_event"),
    "compare": ("compare", "GOOD", "BAG"),
    "compare none": ("compare", "BAG", "GOOD", "--align", "none", "--gap-tolerance", "1"),
    "check": ("check", "BAG"),
    "repair": ("check", "--repair", "BAG"),
    "check again": ("check", "BAG"),
    "info again": ("info", "BAG"),
}


class _Publisher:
    """In place of one of rclpy: only DDS is left out."""

    msg_type = str
    topic_name = ""

    def publish(self, message: object) -> None:
        self.last = message

    def wait_for_all_acked(self, timeout: object) -> bool:
        return True


class _Node:
    def create_publisher(self, kind: object, name: str, profile: object) -> _Publisher:
        return _Publisher()


class _Observer:
    node = _Node()

    def prefetched_graph(self) -> None:
        return None

    def graph_snapshot(self) -> GraphSnapshot:
        return GraphSnapshot(domain_id=0, nodes=(), infos=())


@contextlib.contextmanager
def _observing(options: object) -> Iterator[_Observer]:
    yield _Observer()


def _status_kib(name: str) -> int:
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(f"{name}:"):
            return int(line.split()[1])
    return 0


def _forget_peak() -> None:
    Path("/proc/self/clear_refs").write_text("5")


def run(words: tuple[str, ...]) -> dict[str, Any]:
    """The outcome of one verb: exit code, what is wrong with it, peak of memory."""
    out, err = io.StringIO(), io.StringIO()
    problem, code = "", -1
    _forget_peak()
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = main(["bag", *words])
    except BaseException:
        problem = traceback.format_exc()
    told = err.getvalue()
    if not problem:
        problem = _problem(code, out.getvalue(), told)
    return {"code": code, "problem": problem, "kib": _status_kib("VmHWM"), "told": told[:300]}


def _problem(code: int, out: str, err: str) -> str:
    if code not in (0, 1):
        return f"exit code {code}: {err}"
    if code and not (err or out):
        return "no word"
    for word in ("Traceback", "MemoryError", "RecursionError", "cannot write", "cannot allocate"):
        if word in err or word in out:
            return f"{word}: {err[:500]}"
    errors = [line for line in err.splitlines() if line.startswith("error:")]
    if len(errors) > 1 or any(len(line) > 1000 for line in errors):
        return f"not one sentence: {err[:2000]}"
    return ""


def case(seeds: Path, folder: Path, kind: str, number: int) -> dict[str, Any]:
    """Mutate one bag; the outcomes of all verbs."""
    shutil.rmtree(folder, ignore_errors=True)
    bag = folder / "bag"
    shutil.copytree(seeds / kind, bag)
    mutate(mutable(bag, kind), kind, number)
    if kind != "metadata" and number % 3 == 0:
        bag = mutable(bag, kind)
    found = {}
    for verb, words in VERBS.items():
        places = {"BAG": str(bag), "GOOD": str(seeds / kind)}
        output = folder / "out"
        found[verb] = run(
            tuple(places.get(word, word.replace("OUT", str(output))) for word in words)
        )
        left = [one for one in folder.iterdir() if one.name.startswith("out")]
        if verb.startswith("convert") and found[verb]["code"] and left:
            found[verb]["problem"] = f"left {left[0].name}"
        for one in left:
            shutil.rmtree(one) if one.is_dir() else one.unlink()
    if found["repair"]["code"] == 0 and found["check again"]["code"] != 0:
        found["check again"]["problem"] = "a repaired bag is not whole"
    return found


def serve(seeds: Path, folder: Path) -> None:
    from launcher.bag.ros import publishers
    from launcher.bag.ros.publishers import Publishers  # noqa: F401  (before memory is limited)
    from launcher.ros.messages import classes

    play_module.observing = _observing  # type: ignore[assignment]
    publishers.with_library = classes.with_library
    run(("play", str(seeds / "mcap"), "-r", "1e18", "--disable-keyboard-controls"))
    limit = _status_kib("VmSize") * 1024 + MEMORY_BYTES
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    answers = os.fdopen(os.dup(1), "w")
    for line in sys.stdin:
        kind, _, number = line.rstrip("\n").rpartition(" ")
        answers.write(json.dumps(case(seeds, folder, kind, int(number))) + "\n")
        answers.flush()


if __name__ == "__main__":
    serve(Path(sys.argv[1]), Path(sys.argv[2]))
