"""`bag compare`: whether two bags are alike."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from launcher.bag.verbs.info import warn_of
from launcher.bag.verbs.topics import SELECT, selected
from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode
from launcher.base.option import DEBUG, JSON, number, option
from launcher.base.text import aligned, count
from launcher.ros.verb import show

if TYPE_CHECKING:
    from launcher.bag.comparing.compare import Comparison, TopicComparison
    from launcher.bag.comparing.topic_traits import Limit, Traits
    from launcher.bag.reader import Bag

_ALIGNMENTS = ("start", "none")
_HEAD = ("topic", "messages", "rate (Hz)", "longest gap (s)", "latency (ms)", "99 % (ms)")


def _least_zero(word: str) -> float:
    value = number(word)
    if not 0 <= value < float("inf"):
        raise ValueError(f"'{word}' is not a number of at least 0")
    return value


def _ratio(word: str) -> float:
    """`10%` or `0.1`."""
    if word.endswith("%"):
        return _least_zero(word[:-1].rstrip()) / 100
    return _least_zero(word)


def _share(word: str) -> Limit:
    from launcher.bag.comparing.topic_traits import Limit

    return Limit(relative=_ratio(word))


def _number_or_share(word: str) -> Limit:
    from launcher.bag.comparing.topic_traits import Limit

    return _share(word) if word.endswith("%") else Limit(absolute=_least_zero(word))


def _compare(options: Parsed) -> int:
    from launcher.bag.comparing.compare import CompareOptions, compare, document
    from launcher.bag.comparing.field_difference import Rules
    from launcher.bag.comparing.topic_traits import Limit, Tolerances
    from launcher.bag.reader import Bag
    from launcher.posix.allocator import keep_freed_memory

    keep_freed_memory()
    bags = Bag(options.a), Bag(options.b)
    for bag in bags:
        warn_of(bag)
    rules = Rules(
        absolute=options.tolerance,
        relative=options.relative_tolerance,
        ignored=frozenset(options.ignore_field or ()),
        stamps=options.ignore_stamps,
    )
    result = compare(
        *bags,
        CompareOptions(
            selection=selected(options),
            tolerances=Tolerances(
                count=options.count_tolerance or Limit(),
                rate=options.rate_tolerance or Limit(relative=0.1),
                gap=options.gap_tolerance,
            ),
            fields=None if options.no_fields else rules,
            align=options.align,
        ),
    )
    paths = {"a": options.a, "b": options.b}
    show(options, document(result, paths), _lines(result, bags, options.align))
    return ExitCode.OK if result.alike else ExitCode.PROCESS_FAILED


def _lines(result: Comparison, bags: tuple[Bag, Bag], align: str) -> Iterator[str]:
    from launcher.bag.comparing.topic_traits import text_of

    for letter, bag in zip("AB", bags, strict=True):
        seconds = bag.extent.duration_ns / 1e9
        yield f"{letter}: {bag.path}: {count(bag.extent.total, 'message')} in {seconds:.3f} s"
    if result.shift_ns:
        later = "later" if result.shift_ns > 0 else "earlier"
        what = "the times count from each start" if align == "start" else "the time of both counts"
        yield f"B begins {abs(result.shift_ns) / 1e9:.3f} s {later} than A; {what}"
    if result.topics:
        yield ""
        yield from aligned([_HEAD, *map(_row, result.topics)])
    yield ""
    number = 0
    for topic in result.topics:
        for one in topic.differences:
            yield f"{topic.name}: {text_of(one)}"
            number += 1
    yield f"{count(number, 'difference')}" if number else "the bags are alike"


def _row(topic: TopicComparison) -> tuple[str, ...]:
    def cell(value: Callable[[Traits], float | None], form: str, factor: float = 1) -> str:
        """`10`, or `10 / 9.8` where A and B differ."""
        texts = []
        for one in (topic.a, topic.b):
            found = None if one is None else value(one)
            texts.append("-" if found is None else f"{found * factor:{form}}")
        return texts[0] if texts[0] == texts[1] else " / ".join(texts)

    return (
        topic.name,
        cell(lambda one: one.count, "d"),
        cell(lambda one: one.rate_hz, ".3g"),
        cell(lambda one: one.gap_s, ".3g"),
        cell(lambda one: one.latency_s, ".3g", 1e3),
        cell(lambda one: one.latency_p99_s, ".3g", 1e3),
    )


COMMAND = Command(
    "bag compare",
    "find out whether two bags are alike",
    about="Compare topics, types, numbers and rates of messages of two bags, and the contents: "
    "message n of a topic with message n of it in the other bag, up to the first difference. Exit "
    "code 1 if something differs.",
    arguments=(
        option("BAG", "A: folder, or .mcap or .db3 file", name="a"),
        option("OTHER", "B, the other bag", name="b"),
    ),
    options=(
        *SELECT,
        option("--no-fields", "do not compare contents"),
        option("--tolerance ABS", "numbers may differ by so much", _least_zero, 0.0),
        option("--relative-tolerance R", "numbers may differ by this part (10%, 0.1)", _ratio, 0.0),
        option("--ignore-field PATH", "a field: a.b, of all elements, or a[0].b", repeat="all"),
        option("--ignore-stamps", "ignore the stamps of headers"),
        option(
            "--count-tolerance N", "numbers of messages may differ by N, or N%", _number_or_share
        ),
        option("--rate-tolerance R", "rates may differ by this part (default: 10%)", _share),
        option("--gap-tolerance R", "the longest gap of B may be longer by this part", _share),
        option(
            "--align HOW",
            "start: times count from the start of each bag; none: only the time is compared that "
            "both have by their clocks",
            choices=_ALIGNMENTS,
            default="start",
        ),
        JSON,
        DEBUG,
    ),
    abbreviations=True,
    run=_compare,
)
