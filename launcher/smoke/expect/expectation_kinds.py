"""Kinds: every kind of expectation there is, its entries, and who judges it.

One table for the loader, the JSON Schema, the flags and the documentation.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from launcher.smoke.expect.expectation import Expectation, Verdict
from launcher.smoke.expect.fields import (
    Anything,
    Choice,
    Field,
    FieldConditions,
    FieldType,
    Flag,
    Mapped,
    Name,
    NamePattern,
    RecordField,
    Regex,
    Regexes,
    Text,
    TypeName,
    Where,
)
from launcher.smoke.expect.quantities import (
    COUNT,
    DURATION,
    EXIT,
    PERCENT,
    RATE,
    SIZE,
    WINDOW,
    Span,
)
from launcher.smoke.judges import answers, graph, logs, processes, run, traffic
from launcher.smoke.observe.facts import Facts

PRESENCE_WITHIN = Span(low=0.0, high=10.0, text="10 s")


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """`name` is the key whose value is the subject.

    `default_within` counts where no time is given; `timed` is whether `within` and `after` make
    sense; `one_of` are entries of which at least one has to be there.
    """

    name: str
    subject: FieldType
    doc: str
    judge: Callable[[Expectation, Facts], Verdict]
    fields: tuple[Field, ...] = ()
    default_within: Span | None = None
    timed: bool = True
    one_of: tuple[str, ...] = ()
    needs_ros: bool = False

    def all_fields(self) -> tuple[Field, ...]:
        """Its own entries and those of every kind."""
        return (*self.fields, *(COMMON if self.timed else COMMON[:1]))


COMMON = (
    Field(name="name", type=Text("name"), doc="what the reports call it"),
    Field(
        name="within",
        type=WINDOW,
        doc="time that it has, `8 s` or `5 to 8 s`; counts from the start, or from `after`",
    ),
    Field(name="after", type=Text("name of a step"), doc="step from which its time counts"),
)

LEVELS = Choice("DEBUG", "INFO", "WARN", "ERROR", "FATAL")
RELIABILITY = Choice("reliable", "best_effort")
DURABILITY = Choice("volatile", "transient_local")
ENDPOINT_QOS = RecordField(
    "QoS of endpoints",
    reliability=RELIABILITY,
    durability=DURABILITY,
    liveliness=Choice("automatic", "manual_by_topic"),
    deadline=DURATION,
    lease=DURATION,
)
OUR_QOS = RecordField("QoS", reliability=RELIABILITY, durability=DURABILITY, depth=COUNT)

_PROCESS = Field(
    name="process",
    type=Text("process"),
    doc="`robot_2-4`, `robot_2`, `robot_*`, `/node`; `launch` is the launcher itself",
)
_TYPE = Field(
    name="type",
    type=TypeName("msg", "std_msgs/msg/String"),
    doc="type, as in `std_msgs/msg/String`",
)
_SERVICE_TYPE = Field(
    name="type",
    type=TypeName("srv", "std_srvs/srv/SetBool"),
    doc="type, as in `std_srvs/srv/SetBool`",
)
_WHERE = Field(name="where", type=Where(), doc="Python expression over `m` and `json`")
_FIELDS = Field(name="fields", type=FieldConditions(), doc="field path to value or limits")
_OUR_QOS = Field(name="qos", type=OUR_QOS, doc="QoS of our subscription; else what fits")

KINDS = (
    Kind(
        name="node",
        subject=NamePattern("node"),
        doc="A node is in the graph (full name, or a pattern).",
        judge=graph.node,
        fields=(Field(name="absent", type=Flag(), doc="it is gone in time; never there"),),
        default_within=PRESENCE_WITHIN,
        needs_ros=True,
    ),
    Kind(
        name="topic",
        subject=Name("topic"),
        doc="A topic exists, with a type and numbers of endpoints.",
        judge=graph.topic,
        fields=(
            _TYPE,
            Field(name="publishers", type=COUNT, doc="how many publishers"),
            Field(name="subscriptions", type=COUNT, doc="how many subscriptions"),
        ),
        default_within=PRESENCE_WITHIN,
        needs_ros=True,
    ),
    Kind(
        name="qos",
        subject=Name("topic"),
        doc="The quality of service of all publishers or subscriptions of a topic.",
        judge=graph.qos,
        fields=(
            Field(name="publishers", type=ENDPOINT_QOS, doc="what every publisher offers"),
            Field(name="subscriptions", type=ENDPOINT_QOS, doc="what every subscription asks for"),
            Field(name="compatible", type=Flag(), doc="all pairs match, or one does not"),
            Field(name="node", type=NamePattern("node"), doc="only endpoints of these nodes"),
        ),
        default_within=PRESENCE_WITHIN,
        one_of=("publishers", "subscriptions", "compatible"),
        needs_ros=True,
    ),
    Kind(
        name="rate",
        subject=Name("topic"),
        doc="Messages come at a rate.",
        judge=traffic.rate,
        fields=(
            Field(name="is", type=RATE, doc="`1 Hz ± 20 %`, `0.9 to 1.1 Hz`", required=True),
            _WHERE,
            _FIELDS,
            _TYPE,
        ),
        needs_ros=True,
    ),
    Kind(
        name="message",
        subject=Name("topic"),
        doc="A message that satisfies conditions comes; or every message does.",
        judge=traffic.message,
        fields=(
            _WHERE,
            _FIELDS,
            Field(name="count", type=COUNT, doc="how many (default: at least one)"),
            Field(name="all", type=Flag(), doc="every message satisfies the conditions"),
            _TYPE,
            _OUR_QOS,
        ),
        needs_ros=True,
    ),
    Kind(
        name="log",
        subject=Regex(),
        doc="A line that matches is printed.",
        judge=logs.log,
        fields=(
            _PROCESS,
            Field(name="level", type=LEVELS, doc="level of the line"),
            Field(name="count", type=COUNT, doc="how many lines (default: at least one)"),
        ),
    ),
    Kind(
        name="order",
        subject=Regexes(least=2),
        doc="The first lines that match come in this order.",
        judge=logs.order,
        fields=(_PROCESS,),
    ),
    Kind(
        name="no_errors",
        subject=Text("process"),
        doc="No line of level ERROR or FATAL, from a process or (`*`) from anything.",
        judge=logs.no_errors,
        fields=(Field(name="except", type=Regexes(), doc="lines that are no errors"),),
    ),
    Kind(
        name="no_tracebacks",
        subject=Text("process"),
        doc="No traceback of Python, from a process or (`*`) from anything.",
        judge=logs.no_tracebacks,
    ),
    Kind(
        name="process",
        subject=Text("process"),
        doc="A process runs at the end, ends with a code, or is restarted.",
        judge=processes.process,
        fields=(
            Field(name="alive", type=Flag(), doc="it runs at the end (default without others)"),
            Field(name="exits", type=EXIT, doc="it ends with this code or signal"),
            Field(name="restarts", type=COUNT, doc="how often it is started again"),
        ),
    ),
    Kind(
        name="no_deaths",
        subject=Choice("*"),
        doc="No process dies unasked. Every run expects this by itself.",
        judge=processes.no_deaths,
    ),
    Kind(
        name="cpu",
        subject=Text("process"),
        doc="What a process computes, in percent of one core.",
        judge=processes.cpu,
        fields=(
            Field(name="below", type=PERCENT, doc="on average"),
            Field(name="peak", type=PERCENT, doc="at every moment (measured once a second)"),
        ),
        one_of=("below", "peak"),
    ),
    Kind(
        name="memory",
        subject=Text("process"),
        doc="What a process holds in memory, at every moment.",
        judge=processes.memory,
        fields=(Field(name="below", type=SIZE, doc="`200 MB`", required=True),),
    ),
    Kind(
        name="parameter",
        subject=Text("name of a parameter"),
        doc="A parameter has a value.",
        judge=answers.parameter,
        fields=(
            Field(name="node", type=Name("node"), doc="full name of the node", required=True),
            Field(name="is", type=Anything(), doc="value, values or limits", required=True),
        ),
        default_within=PRESENCE_WITHIN,
        needs_ros=True,
    ),
    Kind(
        name="service",
        subject=Name("service"),
        doc="A service answers, with what is expected.",
        judge=answers.service,
        fields=(
            _SERVICE_TYPE,
            Field(name="request", type=Mapped(), doc="the request's fields"),
            Field(
                name="once", type=Flag(), doc="the first answer counts; else called until it fits"
            ),
            _WHERE,
            _FIELDS,
        ),
        default_within=PRESENCE_WITHIN,
        needs_ros=True,
    ),
    Kind(
        name="start_up",
        subject=DURATION,
        doc="The system is ready in time.",
        judge=run.start_up,
        timed=False,
    ),
    Kind(
        name="clean_shutdown",
        subject=DURATION,
        doc="Everything ends by itself in time when it is asked to, and leaves nothing.",
        judge=run.clean_shutdown,
        timed=False,
    ),
    Kind(
        name="shared_memory",
        subject=Choice("clean"),
        doc="Nothing is left in /dev/shm.",
        judge=run.shared_memory,
        timed=False,
    ),
)

BY_NAME = {kind.name: kind for kind in KINDS}


def judge(expectation: Expectation, facts: Facts) -> Verdict:
    """The verdict on one expectation."""
    return BY_NAME[expectation.kind].judge(expectation, facts)
