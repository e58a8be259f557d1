"""A chart of curves over the time of the incident.

The drawing is stretched to any width, so it has only lines whose width does not scale; texts are
HTML beside it, which stays readable.
"""

from __future__ import annotations

import itertools
import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from launcher.faults.incident.markup import EMPTY, Markup, join, tag
from launcher.faults.incident.parts.series import Curve, nice_top
from launcher.faults.incident.parts.span import WIDTH, TimeSpan, tick_text

HEIGHT = 100.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ChartLine:
    """A curve; `name` is for the legend and `style` a class of page.css."""

    name: str
    curve: Curve
    style: str = "line-a"
    stepped: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Chart:
    """`limits` are values that are drawn across; `bands` times that are shaded."""

    title: str
    about: object = EMPTY
    lines: Sequence[ChartLine]
    show: Callable[[float], str]
    summary: str
    limits: Sequence[float] = ()
    bands: Sequence[tuple[float, float]] = ()
    marks: Sequence[float] = field(default=())
    top: float | None = None

    def markup(self, span: TimeSpan) -> Markup:
        values = [value for line in self.lines for _, value in line.curve]
        top = self.top or nice_top(max([*values, *self.limits], default=1.0) * 1.05)
        head = [tag("strong", self.title), tag("span", self.about, class_="muted")]
        if len(self.lines) > 1:
            keys = [key(line.style, line.name) for line in self.lines]
            head.append(tag("span", *keys, class_="legend-line"))
        return tag(
            "figure",
            tag("figcaption", *head),
            tag(
                "div",
                tag("div", tag("span", self.show(top)), tag("span", self.show(0)), class_="y"),
                tag(
                    "svg",
                    tag("title", self.summary),
                    self._bands(span),
                    axes(span),
                    join(_across(limit, top) for limit in self.limits if limit <= top),
                    join(_drawn(line, span, top) for line in self.lines),
                    _marks(self.marks, span),
                    **drawing(HEIGHT),
                ),
                ticks(span),
                class_="chart",
            ),
            tag("p", self.summary, class_="muted small"),
            class_="plot",
        )

    def _bands(self, span: TimeSpan) -> Markup:
        return join(bar(span, start, end, "band") for start, end in self.bands)


def drawing(height: float) -> dict[str, object]:
    """The attributes of a drawing as wide as its place."""
    return {
        "viewBox": f"0 0 {WIDTH:g} {height:g}",
        "preserveAspectRatio": "none",
        "role": "img",
        "focusable": "false",
    }


def axes(span: TimeSpan, height: float = HEIGHT) -> Markup:
    """Lines at the ticks, and one at the opening of the incident."""
    lines = join(_path(f"M{span.x(at)} 0V{height:g}", "grid") for at in span.ticks())
    return join([lines, _path(f"M{span.x(span.zero_s)} 0V{height:g}", "opened")])


def ticks(span: TimeSpan) -> Markup:
    """The texts below a drawing."""
    found = span.ticks()
    return tag(
        "div",
        *(
            tag("span", tick_text(at, span.zero_s), style=f"left:{span.percent(at)}")
            for at in found
            if 2 <= span.x(at) / WIDTH * 100 <= 98
        ),
        class_="x",
        aria_hidden="true",
    )


def bar(
    span: TimeSpan,
    start_s: float,
    end_s: float,
    style: str,
    *,
    top: int = 0,
    height: float = HEIGHT,
) -> Markup:
    """The time from one to the other; nothing if that is not in the span."""
    left, right = span.x(start_s), span.x(end_s)
    if right <= left:
        return EMPTY
    return tag("rect", x=left, y=top, width=round(right - left, 2), height=height, class_=style)


def dot(x: float, y: float, style: str, title: object = EMPTY) -> Markup:
    """A round mark: a line without length, whose ends are round, is not stretched."""
    return tag("path", tag("title", title), d=f"M{x:g} {y:g}h0.01", class_=f"dot {style}")


def _path(steps: str, style: str) -> Markup:
    return tag("path", d=steps, class_=style)


def _across(value: float, top: float) -> Markup:
    return _path(f"M0 {_y(value, top)}H{WIDTH:g}", "limit")


def _y(value: float, top: float) -> str:
    return f"{HEIGHT - min(max(value / top, 0.0), 1.0) * HEIGHT:.1f}"


def _drawn(line: ChartLine, span: TimeSpan, top: float) -> Markup:
    points = [(span.x(at_s), _y(value, top)) for at_s, value in line.curve if span.holds(at_s)]
    if not points:
        return EMPTY
    if len(points) == 1:
        return dot(points[0][0], float(points[0][1]), line.style)
    pause = _pause([x for x, _ in points])
    steps = [f"M{points[0][0]:g} {points[0][1]}"]
    for (x_before, y_before), (x, y) in itertools.pairwise(points):
        if x - x_before > pause and not line.stepped:
            steps.append(f"M{x:g} {y}")  # nothing is known in between
        else:
            steps.append(f"H{x:g}V{y}" if line.stepped and y != y_before else f"L{x:g} {y}")
    return _path("".join(steps), f"line {line.style}")


def _pause(places: Sequence[float]) -> float:
    """A longer distance between two points is a gap."""
    distances = [b - a for a, b in itertools.pairwise(places)]
    return max(3.5 * statistics.median(distances), WIDTH / 100)


def _marks(times: Sequence[float], span: TimeSpan) -> Markup:
    if not times:
        return EMPTY
    return _path("".join(f"M{span.x(at):g} {HEIGHT - 6:g}v6" for at in times), "rug")


def key(style: str, name: str) -> Markup:
    """An item of a legend."""
    return tag("span", tag("span", EMPTY, class_=f"swatch {style}"), name, class_="key")
