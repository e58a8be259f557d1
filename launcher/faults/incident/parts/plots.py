"""Charts of the topics, the processes and the machine."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from launcher.bag.quantity_texts import size
from launcher.base.text import count
from launcher.faults.incident.document import IncidentDocument, Point, ReportedFault, ReportedTopic
from launcher.faults.incident.limits import PageLimits
from launcher.faults.incident.markup import EMPTY, Markup, facts, join, section, tag
from launcher.faults.incident.parts import series
from launcher.faults.incident.parts.chart import Chart, ChartLine
from launcher.faults.incident.parts.span import MINUS, TimeSpan, length, offset

MAX_TOPICS = 24
MAX_PROCESSES = 12
_STYLES = ("line-a", "line-b", "line-c")
_KIBI = 1024.0


def topics(incident: IncidentDocument, span: TimeSpan, limits: PageLimits) -> Markup:
    """Rates, and delays where they were measured."""
    chosen = list(incident.topics.items())
    shown = [
        chart.markup(span)
        for name, topic in chosen[: limits.of(MAX_TOPICS)]
        for chart in _of_topic(name, topic, incident, span)
    ]
    return _in_question("topics", shown, len(chosen) - limits.of(MAX_TOPICS))


def _in_question(name: str, charts: Sequence[Markup], more: int) -> Markup:
    """The section of the topics or processes in question, of which `more` are left out."""
    note = tag("p", f"{more} more in the document.") if more > 0 else EMPTY
    grid = tag("div", *charts, class_="plots") if charts else EMPTY
    return section(name, f"{name.capitalize()} in question", grid, note)


def _of_topic(
    name: str, topic: ReportedTopic, incident: IncidentDocument, span: TimeSpan
) -> Iterator[Chart]:
    own = [fault for fault in incident.faults if name in fault.topics]
    expected = _expected_rate([topic.expected or "", *_expected_of(own)])
    about = ", ".join(filter(None, [topic.type, f"expected: {expected}" if expected else ""]))
    shown = _arrivals_of(topic)
    texts = [
        f"{of}: {_arrivals_text(times, span)}" if topic.fitting else _arrivals_text(times, span)
        for of, times in shown.items()
    ]
    until_s = _observed_until(incident)
    yield Chart(
        title=name,
        about=about,
        lines=[
            ChartLine(name=of, curve=series.rates(times, span, until_s), style=style, stepped=True)
            for (of, times), style in zip(shown.items(), _STYLES, strict=False)
        ],
        show=lambda value: f"{value:g} Hz",
        summary=" ".join(texts) if topic.is_watched else "When messages came was not watched.",
        limits=series.expected_hz(expected),
        bands=_bands(own, span),
        marks=series.thinned(next(iter(shown.values())), span),
    )
    delays = series.highest([(row[0], row[1]) for row in topic.delays], span)
    if delays:
        limit = next((one.expected for one in own if one.kind == "latency"), None)
        limit_s = series.expected_seconds(limit)
        worst = max(value for _, value in delays)
        yield Chart(
            title=f"{name}: delay",
            about=f"expected: {limit}" if limit else "from the sender to the reception",
            lines=[ChartLine(name="delay", curve=delays, style="line-b")],
            show=_delay,
            summary=f"The highest delay is {_delay(worst)}.",
            limits=[] if limit_s is None else [limit_s],
            bands=_bands(own, span),
        )


def _arrivals_of(topic: ReportedTopic) -> dict[str, Sequence[float]]:
    """Those that a fault is about first: others may come while these are missing."""
    fitting = [*topic.fitting.items()][: len(_STYLES) - 1]
    return {**dict(fitting), "all messages": topic.arrivals}


def _observed_until(incident: IncidentDocument) -> float:
    """The time of the last measurement of any kind."""
    rows = [*incident.processes.values(), incident.machine]
    ends = [one[-1][0] for one in rows if one]
    ends += [one.arrivals[-1] for one in incident.topics.values() if one.arrivals]
    return max(ends, default=0.0)


def _expected_of(own: Sequence[ReportedFault]) -> Iterator[str]:
    """What the faults say about anything but the delay."""
    yield from (one.expected for one in own if one.kind != "latency")


def _expected_rate(texts: Sequence[str]) -> str | None:
    """The first text about a rate, else the first."""
    known = [one for one in texts if one]
    return next((one for one in known if series.expected_hz(one)), next(iter(known), None))


def _delay(value: float) -> str:
    return f"{value * 1000:.3g} ms" if abs(value) < 1 else f"{value:.3g} s"


def _arrivals_text(arrivals: Sequence[float], span: TimeSpan) -> str:
    times = [one for one in arrivals if span.holds(one)]
    if not times:
        return "No message was received in this time."
    gap = series.longest_gap(arrivals, span)
    text = f"{count(len(times), 'message')}, the last one at {offset(times[-1], span.zero_s)}"
    if gap is not None and len(times) > 1:
        text += f"; the longest pause is {length(gap[1])}, from {offset(gap[0], span.zero_s)} on"
    return f"{text}."


def _bands(faults: Sequence[ReportedFault], span: TimeSpan) -> list[tuple[float, float]]:
    """From the first violation of each to its end; where they overlap, once."""
    found: list[tuple[float, float]] = []
    starts = [(one, one.first_s) for one in faults]
    for fault, first_s in sorted(
        ((one, at) for one, at in starts if at is not None), key=lambda pair: pair[1]
    ):
        end_s = span.end_s if fault.healed_s is None else fault.healed_s
        if found and first_s <= found[-1][1]:
            found[-1] = (found[-1][0], max(found[-1][1], end_s))
        else:
            found.append((first_s, end_s))
    return found


# ---- processes and the machine


def processes(incident: IncidentDocument, span: TimeSpan, limits: PageLimits) -> Markup:
    """CPU and memory."""
    named = [one for one in incident.processes_in_question if incident.processes.get(one)]
    shown = []
    for name in named[: limits.of(MAX_PROCESSES)]:
        own = [fault for fault in incident.faults if name in fault.processes]
        for chart in _of_process(name, incident.processes[name], _bands(own, span), span):
            shown.append(chart.markup(span))
    return _in_question("processes", shown, len(named) - limits.of(MAX_PROCESSES))


def _of_process(
    name: str, samples: Sequence[Point], bands: Sequence[tuple[float, float]], span: TimeSpan
) -> Iterator[Chart]:
    cpu = series.highest([(row[0], row[1]) for row in samples], span)
    memory = series.highest([(row[0], row[2]) for row in samples], span)
    if cpu:
        yield Chart(
            title=f"{name}: CPU",
            about="of one core",
            lines=[ChartLine(name="CPU", curve=cpu)],
            show=lambda value: f"{value:g} %",
            summary=f"At most {max(value for _, value in cpu):.0f} % of a core.",
            bands=bands,
        )
    if memory:
        first, last = memory[0], memory[-1]
        change = last[1] - first[1]
        sign = MINUS if change < 0 else "+"
        yield Chart(
            title=f"{name}: memory",
            about="that is resident, with what it shares with others (RSS)",
            lines=[ChartLine(name="memory", curve=memory, style="line-b")],
            show=lambda value: size(round(value)),
            summary=f"{size(round(last[1]))} at the end, {sign}{size(round(abs(change)))} "
            f"in {length(last[0] - first[0])}.",
            bands=bands,
            top=_binary_top(max(value for _, value in memory)),
        )


def _binary_top(value: float) -> float:
    """A round number of KiB, MiB or GiB."""
    unit = _KIBI ** max(0, int(math.log(max(value, 1.0), _KIBI)))
    return series.nice_top(value * 1.05 / unit) * unit


def machine(incident: IncidentDocument, span: TimeSpan) -> Markup:
    """Pressure, the log disk and the clock."""
    names = (("CPU", "line-a"), ("memory", "line-b"), ("I/O", "line-c"))
    lines = [
        ChartLine(
            name=name,
            curve=series.highest([(row[0], row[column]) for row in incident.machine], span),
            style=style,
        )
        for column, (name, style) in enumerate(names, 1)
    ]
    known = [line for line in lines if line.curve]
    shown = EMPTY
    if known:
        most = ", ".join(f"{one.name} {max(v for _, v in one.curve):.0f} %" for one in known)
        chart = Chart(
            title="Pressure",
            about="part of the time in which processes waited",
            lines=known,
            show=lambda value: f"{value:g} %",
            summary=f"At most: {most}.",
            top=100.0,
        )
        shown = tag("div", chart.markup(span), class_="plots")
    free = [row[4] for row in incident.machine if not math.isnan(row[4])]
    steps = [row[5] for row in incident.machine if not math.isnan(row[5])]
    rows = [
        ("Free on the log disk", f"at least {size(round(min(free)))}" if free else None),
        ("Clock step", _step_text(max(steps, key=abs)) if steps else None),
    ]
    return section("machine", "Machine", join([shown, facts(rows)]))


def _step_text(step_s: float) -> str:
    return "none" if abs(step_s) < 0.001 else f"{step_s:+.3f} s"
