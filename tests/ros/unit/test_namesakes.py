"""Which nodes with names of ours are reported: those that are of others for certain, twice."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence

import pytest

from launcher.ros.helpers import namesakes
from launcher.ros.helpers.namesakes import Namesake, NamesakeSearch, warning

HERE = Namesake("/talker", 4711, "pid 4711", is_foreign=True)
AGAIN = Namesake("/talker", 4712, "pid 4712", is_foreign=True)
OTHER = Namesake("/other", 4711, "pid 4711", is_foreign=True)
THERE = Namesake("/talker", b"guid", "at 10.0.0.7", is_foreign=False)

Look = tuple[list[Namesake], set[str]]  # what is there, and the nodes in processes of ours


class Scripted(NamesakeSearch):
    """A search that sees what it is given, the last look again and again."""

    def __init__(self, names: Sequence[str | None], looks: Sequence[Look]) -> None:
        super().__init__("run", 1, names)
        self._looks = list(looks)
        self.count = 0

    def _look(self) -> Iterator[Namesake]:
        found, seen = self._looks[min(self.count, len(self._looks) - 1)]
        self.count += 1
        self._seen |= seen
        yield from found


@pytest.fixture(autouse=True)
def _no_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(namesakes, "ROUND_S", 0.0)


@pytest.mark.parametrize(
    ("names", "looks", "found", "count"),
    [
        (["/talker"], [([], set())], [], 1),
        (["/talker"], [([OTHER], set())], [], 1),
        (["/talker"], [([HERE], set())], [HERE], 2),
        (["/talker"], [([HERE], set()), ([], set())], [], 2),  # it was being stopped
        (["/talker"], [([HERE], set()), ([AGAIN], set())], [AGAIN], 3),  # it was restarted
        (["/talker"], [([THERE], set())], [], namesakes.ROUNDS),  # may be ours, by ssh
        (["/talker"], [([THERE], set()), ([THERE], {"/talker"})], [THERE], 3),
        ([None], [([OTHER], set()), ([OTHER], {"/other"})], [OTHER], 3),
        ([None], [([OTHER], {"/mine"})], [], 1),
        ([None], [([], set())], [], 1),
    ],
)
def test_what_is_foreign_and_there_twice_is_found(
    names: list[str | None], looks: list[Look], found: list[Namesake], count: int
):
    search = Scripted(names, looks)
    assert search.run(threading.Event()) == found
    assert search.count == count


def test_a_run_that_ends_is_not_waited_for():
    over = threading.Event()
    over.set()
    search = Scripted(["/talker"], [([THERE], set())])
    assert search.run(over) == []
    assert search.count == 1


def test_one_warning_names_all_places():
    found = [HERE, OTHER, THERE, HERE]
    text = warning(7, found)
    assert text.startswith(
        "ROS domain 7 already has nodes with names of this run: /other, /talker (pid 4711), "
        "/talker (at 10.0.0.7); to keep the two apart, start one with ROS_DOMAIN_ID="
    )
    assert text.endswith(", which is free, or --private")
