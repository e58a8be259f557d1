"""The page of an incident: complete, small, the same for the same document, and only our markup."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from typing import Any

import pytest

from launcher.faults.incident import document, page
from launcher.faults.incident.document import IncidentDocument
from launcher.faults.incident.markup import EMPTY, plain, tag
from launcher.faults.incident.parts import fault_tree, series
from launcher.faults.incident.parts.graph_change import changes, known_graph
from launcher.faults.incident.parts.span import TimeSpan, span_of
from tests.support.incidents import OPENED_S, fault, graph, incident_document

PIECES = (
    "</script></style></title><svg onload=alert(3)>",
    "<img src=x onerror=alert(1)>",
    "<!-- ",
    "]]>",
    '" onmouseover="alert(8)" x="',
    "' autofocus onfocus=alert(9) '",
    "&lt;b&gt;&#60;i&#62;&quot;",
    "\x1b[31;1mred\x1b[0m\x1b[999m\x1b]0;title\x07",
    "\u202edesrever\u2066",
    "\u2028\u2029\ufeff\u0000\u0008",
    "\ud800",
    "javascript:alert(7)",
    "{{constructor}}${alert(6)}@DATA@",
    "\\N\\l\\E",
    "a" * 250,
    "漢字🤖",
)
STRUCTURE = ("event", "direction", "state")  # whose values have a meaning
ELEMENTS = """
html head meta title style body main header h1 h2 h3 p span section dl div dt dd code strong ol ul
li article details summary pre table thead tbody tr th td figure figcaption svg g path rect polygon
ellipse text mark input label a footer
"""


def whole(incident: IncidentDocument, plan: Any = None) -> str:
    return page.document(incident, page.render(incident, plan), EMPTY)


def poisoned(value: Any, seed: int) -> Any:
    """The value with a hostile text behind each text, the same behind the same one."""
    if isinstance(value, str):
        return value + PIECES[(sum(value.encode()) + seed) % len(PIECES)]
    if isinstance(value, dict):
        names = ("/", "robot_1-3")
        return {
            (poisoned(key, seed) if key.startswith(names) else key): one
            if key in STRUCTURE
            else poisoned(one, seed)
            for key, one in value.items()
        }
    return [poisoned(one, seed) for one in value] if isinstance(value, list) else value


class _Elements(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))

    def handle_comment(self, data: str) -> None:
        self.found.append((f"comment {data}", {}))


@pytest.mark.parametrize("seed", range(0, len(PIECES), 3))
def test_no_text_becomes_markup(seed: int):
    given = poisoned(incident_document(), seed)
    plan = {"processes": [{"label": PIECES[seed], "cmd": [PIECES[seed], PIECES[0]]}]}
    text = whole(document.from_value(given), plan)
    parser = _Elements()

    parser.feed(text)

    assert text.count('class="drawing"') == 2  # else the names are not in drawings
    assert {name for name, _ in parser.found} <= set(ELEMENTS.split())
    for name, attributes in parser.found:
        assert not [key for key in attributes if key.startswith("on")]
        assert not attributes.keys() & {"src", "srcdoc", "href", "id"} - {"id"}, name
    assert not re.search(
        "[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u202a-\u202e\u2066-\u2069]", text
    )
    text.encode("utf-8")  # no halves of surrogates


def test_invisible_characters_are_shown_and_colours_are_not():
    assert plain("\x1b[31mred\x1b[0m \u202eback\ud800\x00") == "red \\u202eback\\ud800\\x00"
    assert tag("b", "<", title='"') == '<b title="&quot;">&lt;</b>'


def test_every_part_is_there_in_its_order():
    text = whole(document.from_value(incident_document()), {"processes": []})

    found = re.findall(r'<section aria-labelledby="[^"]*" id="(\w+)"|<section id="(\w+)"', text)
    names = [a or b for a, b in found]
    assert " ".join(names) == ("run causes faults timeline graph topics processes machine log plan")
    assert "<title>robot_1-3 was killed by SIGKILL" in text
    assert "Content-Security-Policy" in text
    for word in (
        "enable_debug:=true",
        "9f2c1a7e5b",
        "system.expect.yaml:12",
        "closed after 8.31 s",
    ):
        assert word in text
    assert "<mark>[INFO] [1796054844.1] [robot_1]: Task deliver_dock_2 complete</mark>" in text


def test_the_same_document_makes_the_same_page():
    assert whole(document.from_value(incident_document())) == whole(
        document.from_value(incident_document())
    )


def test_an_empty_document_makes_a_page():
    assert "An incident without a title" in whole(document.from_value({}))


@pytest.mark.thorough
def test_a_large_incident_makes_a_small_page():
    times = [OPENED_S + n / 100 for n in range(-1100, 1100)]
    word = "<\"&'>" * 200
    given = incident_document(
        title=word * 10,
        faults=[
            fault(f"f{n}", lines=[word] * 20, message={"a": word * 8}, seen=word, topics=["/t1"])
            for n in range(110)
        ],
        topics={
            f"/t{n}": {"arrivals": times, "delays": [[t, 0.1] for t in times]} for n in range(30)
        },
        processes={f"p{n}-1": {"samples": [[t, 1.0, 5e6] for t in times]} for n in range(30)},
        machine=[[t, 1, 2, 3, 4, 5] for t in times],
        lines=[{"wall_s": t, "process": "p1-1", "text": word * 2} for t in times],
        events=[{"wall_s": t, "event": word, "process": f"p{n}-1"} for n, t in enumerate(times)],
    )

    text = whole(document.from_value(given))

    assert len(text.encode()) < page.MAX_BYTES
    assert 'id="log"' in text


def test_faults_that_follow_in_a_circle_are_all_shown():
    found = [fault("a", follows="b"), fault("b", follows="a"), fault("c", follows="unknown")]
    incident = document.from_value(incident_document(faults=found))

    roots = fault_tree.roots_of(incident.faults)

    assert [one.fault for one in roots] == ["c", "a"]
    text = whole(incident)
    assert [text.count(f"<h3>{name}</h3>") for name in "abc"] == [1, 1, 1]


# ---- the graph


def test_the_difference_of_graphs_is_said_in_words():
    before, after = known_graph(graph()), known_graph(graph(without="robot_1"))
    assert before is not None
    assert after is not None

    assert changes(before, after) == [
        "Node /robot_1 has gone.",
        "Topic /fleet/status has lost its publisher /robot_1.",
        "Topic /fleet/tasks has lost its subscription /robot_1.",
        "Topic /robot_1/battery has gone, with its publisher /robot_1.",
    ]


def test_a_topic_that_lost_its_last_publisher_is_named_so():
    before, after = known_graph(graph()), known_graph(graph(without="dispatcher"))
    assert before is not None
    assert after is not None

    assert changes(before, after)[1] == (
        "Topic /fleet/tasks has lost its publisher /dispatcher: it has no publisher now."
    )


@pytest.mark.parametrize("value", [None, 3, [], {}, {"nodes": 3}, {"nodes": [3, {}]}])
def test_what_is_no_graph_is_left_out(value: object):
    known = known_graph(value)

    assert known is None or known.graph.nodes == ()


# ---- charts


def test_the_rate_falls_while_a_topic_is_silent():
    span = TimeSpan(0.0, 100.0, 50.0)

    curve = dict(series.rates([n * 0.5 for n in range(100)], span))

    assert curve[min(curve)] == pytest.approx(2.0, rel=0.3)
    assert curve[max(curve)] == pytest.approx(1 / 50, rel=0.1)
    assert max(dict(series.rates([1.0, 2.0], span, until_s=40.0))) < 41
    assert series.rates([], span) == []


def test_a_single_message_has_no_rate():
    assert {rate for _, rate in series.rates([10.0], TimeSpan(0.0, 20.0, 10.0))} == {0.0}


@pytest.mark.parametrize(
    ("text", "rates"),
    [
        ("at least 2 Hz", [2.0]),
        ("1.5 to 3 Hz", [1.5, 3.0]),
        ("rate of /a is 10 Hz ± 20 %", [8.0, 12.0]),
        ("every 200 ms", [5.0]),
        ("no pause above 2 s", []),
        (None, []),
        ("1.2.3 Hz", []),
        ("every 0 s", []),
    ],
)
def test_expected_rates_are_read_from_their_text(text: str | None, rates: list[float]):
    assert series.expected_hz(text) == rates


def test_the_span_is_bounded_around_the_incident():
    given = incident_document(closed_s=OPENED_S + 10)
    given["lines"].append({"wall_s": OPENED_S - 9000, "process": None, "text": "long ago"})
    given["lines"].append({"wall_s": OPENED_S + 9000, "process": None, "text": "long after"})

    span = span_of(document.from_value(given))

    assert 120 <= OPENED_S - span.start_s < 123
    assert 70 <= span.end_s - OPENED_S < 73
