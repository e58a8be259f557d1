"""The timeline: a lane for each fault and process, and the list of what happened."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from launcher.base.text import count
from launcher.faults.incident.document import IncidentDocument, ReportedFault
from launcher.faults.incident.limits import PageLimits, clipped
from launcher.faults.incident.markup import EMPTY, Markup, details, join, section, tag
from launcher.faults.incident.parts.chart import axes, bar, dot, drawing, key, ticks
from launcher.faults.incident.parts.happenings import KINDS, Happening, happenings
from launcher.faults.incident.parts.span import TimeSpan, clock, offset

MAX_LANES = 14  # of faults, and of processes
NEAR = 60  # happenings that are shown without a click
MAX_ROWS = 1000
MAX_TEXT = 600  # characters of a row
_HEIGHT = 28.0


def timeline(incident: IncidentDocument, span: TimeSpan, limits: PageLimits) -> Markup:
    found = happenings(incident)
    lanes = [*_fault_lanes(incident, span), *_process_lanes(incident, found, span)]
    chart = EMPTY
    if lanes:
        chart = tag("div", *lanes, tag("div", ticks(span), class_="lane-x"), class_="lanes")
    used = {one.kind for one in found}
    keys = [key(kind, name) for kind, name in KINDS.items() if kind in used]
    legend = tag("p", *keys, class_="legend small")
    return section("timeline", "Timeline", chart, legend, _list(found, incident.opened_s, limits))


def _fault_lanes(incident: IncidentDocument, span: TimeSpan) -> list[Markup]:
    shown = [one for one in incident.faults if one.first_s is not None][:MAX_LANES]
    return [_lane(one.fault, _life(one, span), _life_text(one, span), span) for one in shown]


def _life(fault: ReportedFault, span: TimeSpan) -> Markup:
    first_s = fault.first_s or span.zero_s
    end_s = span.end_s if fault.healed_s is None else fault.healed_s
    confirmed_s = end_s if fault.confirmed_s is None else fault.confirmed_s
    times = ((first_s, confirmed_s, "suspected"), (confirmed_s, end_s, "active"))
    return join(bar(span, *one, top=8, height=12) for one in times)


def _life_text(fault: ReportedFault, span: TimeSpan) -> str:
    words = [f"first seen {offset(fault.first_s or span.zero_s, span.zero_s)}"]
    if fault.confirmed_s is not None:
        words.append(f"confirmed {offset(fault.confirmed_s, span.zero_s)}")
    if fault.healed_s is not None:
        words.append(f"healed {offset(fault.healed_s, span.zero_s)}")
    return f"Fault {fault.fault}: {', '.join(words)}"


def _process_lanes(
    incident: IncidentDocument, found: Sequence[Happening], span: TimeSpan
) -> list[Markup]:
    """The processes in question first, then others of which something is known, then the run."""
    events = [one for one in found if one.kind not in ("fault", "healed", "cause")]
    about = dict.fromkeys([*incident.processes_in_question, *(one.about for one in events)])
    names = [name for name in about if name][:MAX_LANES]
    lanes = []
    for name in [*names, ""]:
        own = [one for one in events if one.about == name and span.holds(one.at_s)]
        if own:
            text = f"{name or 'the run'}: {count(len(own), 'event')}"
            lanes.append(_lane(name or "run", _dots(own, span), text, span))
    return lanes


def _dots(found: Iterable[Happening], span: TimeSpan) -> Markup:
    """Of several at one place the worst is in front."""
    order = list(KINDS)
    places: dict[tuple[float, str], list[Happening]] = {}
    for one in found:
        places.setdefault((round(span.x(one.at_s) / 2), one.kind), []).append(one)
    worst_last = sorted(places.items(), key=lambda item: -order.index(item[0][1]))
    return join(
        dot(
            span.x(own[0].at_s),
            _HEIGHT / 2,
            kind,
            "; ".join(
                f"{offset(one.at_s, span.zero_s)} {clipped(one.text, 200)}" for one in own[:5]
            ),
        )
        for (_, kind), own in worst_last
    )


def _lane(name: str, inside: Markup, about: str, span: TimeSpan) -> Markup:
    svg = tag("svg", tag("title", about), axes(span, _HEIGHT), inside, **drawing(_HEIGHT))
    return tag("div", tag("span", name, class_="lane-name"), svg, class_="lane")


# ---- the list


def _list(found: Sequence[Happening], zero_s: float, limits: PageLimits) -> Markup:
    if not found:
        return EMPTY
    nearest = sorted(range(len(found)), key=lambda at: abs(found[at].at_s - zero_s))[:NEAR]
    first, last = min(nearest), max(nearest) + 1
    first, last = _bounded(first, last, found, zero_s)
    most = limits.of(MAX_ROWS)
    before = found[max(0, first - most) : first]
    after = found[last : last + most]
    return join(
        [
            _more(before, first, "before", zero_s),
            _table(found[first:last], zero_s),
            _more(after, len(found) - last, "after", zero_s),
        ]
    )


def _bounded(first: int, last: int, found: Sequence[Happening], zero_s: float) -> tuple[int, int]:
    """At most NEAR of them, those around the opening."""
    at = next((n for n in range(len(found)) if found[n].at_s >= zero_s), len(found) - 1)
    half = NEAR // 2
    return max(first, at - half), min(last, at + half)


def _more(found: Sequence[Happening], number: int, side: str, zero_s: float) -> Markup:
    if not found:
        return EMPTY
    left_out = f", {len(found)} of them shown" if number > len(found) else ""
    return details(f"{number} more {side}{left_out}", _table(found, zero_s))


def _table(found: Sequence[Happening], zero_s: float) -> Markup:
    head = tag("tr", *(tag("th", name, scope="col") for name in ("When", "About", "What")))
    rows = [
        tag(
            "tr",
            tag(
                "td", tag("span", offset(one.at_s, zero_s), class_="offset"), title=clock(one.at_s)
            ),
            tag("td", tag("span", EMPTY, class_=f"swatch {one.kind}"), one.about or "run"),
            tag("td", clipped(one.text, MAX_TEXT)),
            class_=f"is-{one.kind}",
        )
        for one in found
    ]
    return tag("table", tag("thead", head), tag("tbody", *rows), class_="happenings")
