"""The kinds of expectations and their entries: one table for the loader, the schema and the docs.

`launcher.smoke.judges` has a judge for each of them.
"""

from __future__ import annotations

from dataclasses import dataclass

from launcher.base.document.fields import (
    FLAG,
    MAPPING,
    Field,
    FieldType,
    choice,
    record,
    text,
)
from launcher.base.document.quantities import (
    COUNT,
    DURATION,
    EXIT,
    GROWTH,
    PERCENT,
    RATE,
    SIZE,
    WINDOW,
    NumberRange,
)
from launcher.output.filters import LEVELS
from launcher.smoke.expect.expectation_fields import (
    CONDITIONS,
    CONFIRMATION,
    EXPRESSION,
    NUMBER,
    PATHS,
    REGEX,
    WANTED,
    name,
    regexes,
    type_name,
)
from launcher.smoke.expect.likeness import LIKENESS


@dataclass(frozen=True, slots=True)
class ExpectationKind:
    """`name` is the key whose value is the subject.

    `default_within` applies where no time is given; `timed`: takes `within` and `after`, and
    `confirm` and `heal`, since it can be judged before the end;
    `one_of`: entries of which at least one is required; `of_process`: the subject is a process.
    """

    name: str
    subject: FieldType
    doc: str
    fields: tuple[Field, ...] = ()
    default_within: NumberRange | None = None
    timed: bool = True
    one_of: tuple[str, ...] = ()
    needs_ros: bool = False
    of_process: bool = False

    def all_fields(self) -> tuple[Field, ...]:
        """Its own entries and those of every kind."""
        return (*self.fields, *(COMMON if self.timed else COMMON[:1]))


COMMON = (
    Field("name", text("name"), "name in reports"),
    Field("within", WINDOW, "time limit, `8 s` or `5 to 8 s`, from the start or from `after`"),
    Field("after", text("step name"), "step from which the time counts"),
    Field("confirm", CONFIRMATION, "in a watched run: `2 s` or `3 times` until it is a fault"),
    Field("heal", DURATION, "in a watched run: time without a violation that ends the fault"),
)
WITHIN_10_S = NumberRange(low=0.0, high=10.0, text="10 s")

RELIABILITIES = ("reliable", "best_effort")
DURABILITIES = ("volatile", "transient_local")
_RELIABILITY = choice(*RELIABILITIES)
_DURABILITY = choice(*DURABILITIES)
_ENDPOINT_QOS = record(
    "QoS of endpoints",
    reliability=_RELIABILITY,
    durability=_DURABILITY,
    liveliness=choice("automatic", "manual_by_topic"),
    deadline=DURATION,
    lease=DURATION,
)
_OWN_QOS = record("QoS", reliability=_RELIABILITY, durability=_DURABILITY, depth=COUNT)
_TOPIC = name("topic")
_NODES = name("node", wildcards=True)
_PROCESSES = text("process name")
_PROCESS = Field(
    "process", _PROCESSES, "`robot_2-4`, `robot_2`, `robot_*`, `/node`; `launch` is the launcher"
)
_TYPE = Field(
    "type", type_name("msg", "std_msgs/msg/String"), "message type, as in `std_msgs/msg/String`"
)
_SERVICE_TYPE = Field(
    "type", type_name("srv", "std_srvs/srv/SetBool"), "service type, as in `std_srvs/srv/SetBool`"
)
_WHERE = Field("where", EXPRESSION, "Python expression over `m` and `json`")
_FIELDS = Field("fields", CONDITIONS, "field path to value or limits")
_MESSAGES = (_WHERE, _FIELDS, _TYPE)  # which ones of a topic count
_KEY = Field("key", PATHS, "field path, or several, as in `task_id`", required=True)

KINDS = (
    ExpectationKind(
        "node",
        _NODES,
        "A node is in the graph (full name or pattern).",
        (
            Field(
                "absent", FLAG, "with `within`: it disappears in time; without: it never appears"
            ),
            Field("count", COUNT, "number of nodes that match, as 1: no second one has this name"),
        ),
        WITHIN_10_S,
        needs_ros=True,
    ),
    ExpectationKind(
        "topic",
        _TOPIC,
        "A topic exists, with a type and numbers of endpoints.",
        (
            _TYPE,
            Field("publishers", COUNT, "number of publishers"),
            Field("subscriptions", COUNT, "number of subscriptions"),
        ),
        WITHIN_10_S,
        needs_ros=True,
    ),
    ExpectationKind(
        "qos",
        _TOPIC,
        "The quality of service of all publishers or subscriptions of a topic.",
        (
            Field("publishers", _ENDPOINT_QOS, "offered by every publisher"),
            Field("subscriptions", _ENDPOINT_QOS, "requested by every subscription"),
            Field("compatible", FLAG, "true: all pairs match; false: at least one does not"),
            Field("node", _NODES, "only endpoints of these nodes"),
        ),
        WITHIN_10_S,
        one_of=("publishers", "subscriptions", "compatible"),
        needs_ros=True,
    ),
    ExpectationKind(
        "rate",
        _TOPIC,
        "Messages arrive at a rate.",
        (Field("is", RATE, "`1 Hz ± 20 %`, `0.9 to 1.1 Hz`", required=True), *_MESSAGES),
        needs_ros=True,
    ),
    ExpectationKind(
        "gap",
        _TOPIC,
        "No pause between messages is too long.",
        (
            Field(
                "below", DURATION, "limit of each pause, also of one that goes on", required=True
            ),
            *_MESSAGES,
        ),
        needs_ros=True,
    ),
    ExpectationKind(
        "latency",
        _TOPIC,
        "Messages are not old when they arrive.",
        (Field("below", DURATION, "limit of 95 % of the messages", required=True), *_MESSAGES),
        needs_ros=True,
    ),
    ExpectationKind(
        "message",
        _TOPIC,
        "A message (or every message) satisfies conditions.",
        (
            _WHERE,
            _FIELDS,
            Field("count", COUNT, "number of messages (default: at least one)"),
            Field("all", FLAG, "every message satisfies the conditions"),
            _TYPE,
            Field("qos", _OWN_QOS, "QoS of the subscription (default: compatible with all)"),
        ),
        needs_ros=True,
    ),
    ExpectationKind(
        "unique",
        _TOPIC,
        "No two messages have the same values.",
        (_KEY, *_MESSAGES),
        needs_ros=True,
    ),
    ExpectationKind(
        "refers",
        _TOPIC,
        "Each message has values that a message on another topic had before.",
        (_KEY, Field("to", _TOPIC, "the other topic", required=True), *_MESSAGES),
        needs_ros=True,
    ),
    ExpectationKind(
        "tally",
        _TOPIC,
        "Messages on another topic count those with different values.",
        (
            _KEY,
            Field("in", _TOPIC, "the other topic", required=True),
            Field("number", NUMBER, "regular expression with a group, the count", required=True),
            Field("lag", DURATION, "how much earlier or later a count may be (default: 1 s)"),
            *_MESSAGES,
        ),
        needs_ros=True,
    ),
    ExpectationKind(
        "log",
        REGEX,
        "A line that matches is printed.",
        (
            _PROCESS,
            Field("level", choice(*LEVELS), "level of the line"),
            Field("count", COUNT, "number of lines (default: at least one)"),
        ),
    ),
    ExpectationKind(
        "order",
        regexes(least=2),
        "The first matching lines come in this order.",
        (_PROCESS,),
    ),
    ExpectationKind(
        "no_errors",
        _PROCESSES,
        "No line of level ERROR or FATAL, from a process or (`*`) from any.",
        (Field("except", regexes(), "lines to ignore"),),
        of_process=True,
    ),
    ExpectationKind(
        "no_tracebacks",
        _PROCESSES,
        "No Python traceback, from a process or (`*`) from any.",
        of_process=True,
    ),
    ExpectationKind(
        "process",
        _PROCESSES,
        "A process runs at the end, exits with a code, or is restarted.",
        (
            Field("alive", FLAG, "runs at the end (default if nothing else is given)"),
            Field("exits", EXIT, "exit code or signal"),
            Field("restarts", COUNT, "number of restarts"),
        ),
        of_process=True,
    ),
    ExpectationKind(
        "ready",
        _PROCESSES,
        "A process is ready, as its `ready_when` in the supervision file says.",
        (),
        WITHIN_10_S,
    ),
    ExpectationKind(
        "no_deaths",
        choice("*"),
        "No process exits unexpectedly. Implied in every run.",
    ),
    ExpectationKind(
        "cpu",
        _PROCESSES,
        "CPU usage of a process, in percent of one core.",
        (
            Field("below", PERCENT, "limit of the average"),
            Field("peak", PERCENT, "limit of every sample (one per second)"),
        ),
        one_of=("below", "peak"),
        of_process=True,
    ),
    ExpectationKind(
        "memory",
        _PROCESSES,
        "Memory usage (USS) of a process, and its growth.",
        (
            Field("below", SIZE, "`200 MB`, in every sample"),
            Field("growth", GROWTH, "limit of the growth after the start, `1 MB/min`"),
        ),
        one_of=("below", "growth"),
        of_process=True,
    ),
    ExpectationKind(
        "parameter",
        text("parameter name"),
        "A parameter has a value.",
        (
            Field("node", name("node"), "full name of the node", required=True),
            Field("is", WANTED, "value, values or limits", required=True),
        ),
        WITHIN_10_S,
        needs_ros=True,
    ),
    ExpectationKind(
        "service",
        name("service"),
        "A service responds as expected.",
        (
            _SERVICE_TYPE,
            Field("request", MAPPING, "fields of the request"),
            Field("once", FLAG, "only the first response counts; default: call until one fits"),
            Field("call", FLAG, "false: it only has to exist, and is never called"),
            _WHERE,
            _FIELDS,
        ),
        WITHIN_10_S,
        needs_ros=True,
    ),
    ExpectationKind(
        "like",
        LIKENESS,
        "Topics, types, rates and gaps are like those of a bag.",
        timed=False,
        needs_ros=True,
    ),
    ExpectationKind("start_up", DURATION, "The system is ready in time.", timed=False),
    ExpectationKind(
        "clean_shutdown",
        DURATION,
        "All processes exit in time when the system is stopped, and leave nothing behind.",
        timed=False,
    ),
    ExpectationKind("shared_memory", choice("clean"), "Nothing is left in /dev/shm.", timed=False),
)

BY_NAME = {kind.name: kind for kind in KINDS}
# The kinds whose topic is subscribed to, and the entries that name another such topic.
OF_MESSAGES = ("rate", "gap", "latency", "message", "unique", "refers", "tally")
OTHER_TOPICS = ("to", "in")
