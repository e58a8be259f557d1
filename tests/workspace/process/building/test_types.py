"""Interfaces with fields of every kind, built by gcc and by zig, sent, shown and judged."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from itertools import count, repeat
from pathlib import Path
from typing import Any

import pytest
import yaml

from tests.support.any_message import has
from tests.support.repository import REPOSITORY
from tests.support.ros_domain import ros_domain
from tests.support.verbs import Answer, eventually, going_on, launcher
from tests.support.workspaces import TYPE_MATRIX, BuiltWorkspace, built_once, run
from tests.support.workspaces import launcher as patient_launcher

pytestmark = pytest.mark.thorough

EXAMPLES = 40
REPEATED = ("-r", "20", "-w", "0", "-p", "999")  # hardly prints: nobody reads it
BUILDS = {"system": (), "zig": ("--compiler", "zig")}

WORD = "grüße \U0001f916"  # of the type server
FLOAT32 = (2 - 2**-23) * 2.0**127
LIMITS = {
    "bool": (False, True),
    "byte": ("\0", "\xff"),
    "char": (0, 255),
    "float32": (-FLOAT32, FLOAT32),
    "float64": (-sys.float_info.max, 5e-324),
    "string": ("", "grüße \U0001f916: [x] 'y' \"z\" # \\ \ttab"),
    "wstring": ("", "grüße \U0001f916"),
    **{f"int{bits}": (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) for bits in (8, 16, 32, 64)},
    **{f"uint{bits}": (0, 2**bits - 1) for bits in (8, 16, 32, 64)},
}
VALUES = {
    "Primitives": {f"{name}_value": high for name, (_, high) in LIMITS.items()},
    "Sequences": {f"{name}_values": [*pair] * 3 for name, pair in LIMITS.items()},
    "Bounded": {f"{name}_values": [*pair, pair[1]] for name, pair in LIMITS.items()},
    "Arrays": {f"{name}_values": [*pair, pair[1]] for name, pair in LIMITS.items()},
    "Strings": {
        "brief": "12345",
        "wide_brief": "äöüß",
        "wide_briefs": ["", "äöü"],
        "few_briefs": ["abc", "d"],
        "two_wide_briefs": ["x", "äöü"],
    },
    "Nested": {
        "header": {"stamp": {"sec": -1, "nanosec": 999999999}, "frame_id": "map"},
        "own": {"state": 255},
        "strings": [{"brief": "a"}, {"wide_brief": "b"}],
        "part": {"name": WORD, "values": [1, -2]},
        "few_parts": [{"name": "one"}, {"values": []}],
        "spans": [{"sec": 2**31 - 1, "nanosec": 1}],
    },
    "FromIdl": {
        "letter": "x",
        "letters": ["a", "7"],
        "raw": "\xff",
        "huge": 2**64 - 1,
        "position": [0.5, -1.0, 1e300],
        "few": [-1, 2],
        "wide_briefs": ["äöü"],
    },
}
DEFAULTS = {
    "bool_value": True,
    "byte_value": "\xff",
    "int64_value": -(2**63),
    "float64_value": sys.float_info.max,
    "string_value": "grüße 'x'",
    "wstring_value": "grüße",
    "string_pair": ["a b", "c, d"],
    "uint64_values": [0, 2**64 - 1],
    "float64_few": [1e-300, -0.0],
}


@pytest.fixture(scope="session")
def matrix(tmp_path_factory: pytest.TempPathFactory) -> BuiltWorkspace:
    """The type matrix, built by the system's compiler."""
    return built_once(tmp_path_factory.getbasetemp(), "matrix_system", TYPE_MATRIX)


@pytest.fixture(scope="module")
def env(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    with ros_domain(tmp_path_factory.mktemp("ros_log")) as env:
        yield env


@pytest.fixture
def server(matrix: BuiltWorkspace, env: dict[str, str]) -> Iterator[None]:
    command = [sys.executable, "-m", "tests.support.type_server"]
    there = matrix.environment(env)
    program = subprocess.Popen(
        command, cwd=REPOSITORY, env=there, stdout=subprocess.PIPE, text=True
    )
    try:
        assert program.stdout is not None
        assert "ready\n" in iter(program.stdout.readline, "")
        yield
    finally:
        program.send_signal(signal.SIGINT)
        program.communicate(timeout=60)


@pytest.mark.parametrize("compiler", BUILDS)
def test_values_of_every_interface_arrive(
    tmp_path_factory: pytest.TempPathFactory, env: dict[str, str], compiler: str
):
    base = tmp_path_factory.getbasetemp()
    workspace = built_once(base, f"matrix_{compiler}", TYPE_MATRIX, *BUILDS[compiler])
    program = [sys.executable, "-m", "tests.support.type_round_trip", str(EXAMPLES)]
    packages = ["matrix_parts", "type_matrix"]
    out = run([*program, *packages], cwd=REPOSITORY, env=workspace.environment(env))
    answers = dict(line.split(" ", 1) for line in out.splitlines() if line.startswith("type_"))
    assert set(answers.values()) == {"ok"}, out
    assert len(answers) == 12


@pytest.mark.parametrize("name", VALUES)
def test_what_is_published_as_yaml_arrives_as_yaml_and_json(
    matrix: BuiltWorkspace, env: dict[str, str], name: str
):
    topic, kind, values = f"/{name.lower()}", f"type_matrix/msg/{name}", VALUES[name]
    publish = ("topic", "pub", topic, kind, yaml.safe_dump(values), *REPEATED)
    with going_on(env, *publish, cwd=matrix.root):
        echo = ("topic", "echo", topic, kind, "--once", "-f")
        shown = launcher(env, *echo, cwd=matrix.root)
        as_json = launcher(env, *echo, "--json", cwd=matrix.root)
        as_csv = launcher(env, *echo, "--csv", cwd=matrix.root)
    (document, _) = yaml.safe_load_all(shown.out)
    assert has(document, values), shown
    assert has(as_json.json()["message"], values), as_json
    assert as_csv.code == 0 and as_csv.out.count(",") >= len(values) - 1


def test_a_message_without_values_has_its_defaults(matrix: BuiltWorkspace, env: dict[str, str]):
    kind = "type_matrix/msg/Defaults"
    with going_on(env, "topic", "pub", "/defaults", kind, *REPEATED, cwd=matrix.root):
        echo = ("topic", "echo", "/defaults", kind, "--once", "-f")
        answer = launcher(env, *echo, cwd=matrix.root)
    (document, _) = yaml.safe_load_all(answer.out)
    assert has(document, DEFAULTS), answer


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ("{brief: '123456'}", "'brief' takes a string of at most 5 characters"),
        ("{few_briefs: [a, b, c]}", "'few_briefs' takes a list of at most 2 values"),
        ("{two_briefs: [a]}", "'two_briefs' takes a list of 2 values"),
        ("{wide_briefs: [abcd]}", "'wide_briefs[0]' takes a string of at most 3 characters"),
    ],
)
def test_values_beyond_a_bound_are_refused(
    matrix: BuiltWorkspace, env: dict[str, str], values: str, said: str
):
    words = ("topic", "pub", "/strings", "type_matrix/msg/Strings", values, "--once")
    answer = launcher(env, *words, cwd=matrix.root)
    assert answer.code != 0
    assert said in answer.err


def test_every_interface_is_listed_and_shown(matrix: BuiltWorkspace, env: dict[str, str]):
    names = [
        f"type_matrix/{path.relative_to(TYPE_MATRIX / 'type_matrix').with_suffix('')}"
        for kind in ("msg", "srv", "action")
        for path in sorted((TYPE_MATRIX / "type_matrix" / kind).iterdir())
    ]
    listed = launcher(env, "interface", "list", cwd=matrix.root)
    assert set(names) <= {line.strip() for line in listed.lines}
    for name in names:
        shown = launcher(env, "interface", "show", name, cwd=matrix.root)
        (source,) = (TYPE_MATRIX / f"{name}.x").parent.glob(f"{name.rpartition('/')[2]}.*")
        lines = {line.rstrip() for line in source.read_text(encoding="utf-8").splitlines()}
        assert lines <= {*shown.lines, ""}, name
        proto = launcher(env, "interface", "proto", name, "--no-quotes", cwd=matrix.root)
        assert proto.code == 0, proto


def answer_of(
    matrix: BuiltWorkspace, env: dict[str, str], service: str, kind: str, request: Iterator[object]
) -> Any:
    """Asked again, with the next request: a service that discovers its client late tells nothing.

    What it has not told is carried out all the same.
    """

    def ask() -> Answer:
        words = (service, f"type_matrix/{kind}", yaml.safe_dump(next(request)))
        return launcher(
            env, "service", "call", *words, "--json", "--timeout", "10", cwd=matrix.root
        )

    return eventually(ask, lambda answer: answer.code == 0).json()["response"]


@pytest.mark.usefixtures("server")
def test_a_service_is_called(matrix: BuiltWorkspace, env: dict[str, str]):
    request = {"one": VALUES["Primitives"], "word": "grüße"}
    response = answer_of(matrix, env, "/swap", "srv/Swap", repeat(request))
    assert has(response, {"other": VALUES["Primitives"], "parts": [{"name": "grüße"}]})


@pytest.mark.usefixtures("server")
def test_an_action_is_used_by_its_topics_and_services(matrix: BuiltWorkspace, env: dict[str, str]):
    goal_ids: list[dict[str, list[int]]] = []

    def goals() -> Iterator[object]:
        for number in count():  # an action server accepts an id once
            goal_ids.append({"uuid": [*range(number, number + 16)]})
            yield {"goal_id": goal_ids[-1], "goal": {"order": 5}}

    def call(service: str, kind: str, request: Iterator[object]) -> Any:
        return answer_of(matrix, env, f"/fold/_action/{service}", f"action/Fold_{kind}", request)

    echo = ("topic", "echo", "/fold/_action/feedback", "type_matrix/action/Fold_FeedbackMessage")
    with going_on(env, *echo, cwd=matrix.root) as listener:
        info = ("topic", "info", "/fold/_action/feedback", "--json")
        eventually(
            lambda: launcher(env, *info, cwd=matrix.root),
            lambda answer: [e for e in answer.json()["endpoints"] if e["direction"] != "publisher"],
        )
        assert call("send_goal", "SendGoal", goals())["accepted"]
        assert listener.stdout is not None
        document = yaml.safe_load("".join(iter(listener.stdout.readline, "---\n")))
    assert document["goal_id"] in goal_ids
    assert document["feedback"]["progress"] == WORD
    result = call("get_result", "GetResult", repeat({"goal_id": goal_ids[-1]}))
    assert has(result, {"status": 4, "result": {"sequence": [*range(5)], "last": {"name": WORD}}})


def test_smoke_judges_fields_of_every_kind(
    matrix: BuiltWorkspace, env: dict[str, str], tmp_path: Path
):
    (tmp_path / "types.launch.py").write_text(
        f"""\
from launch import LaunchDescription
from launch.actions import ExecuteProcess


def generate_launch_description():
    command = [{sys.executable!r}, "-m", "tests.support.type_server"]
    return LaunchDescription([ExecuteProcess(cmd=command, cwd={str(REPOSITORY)!r})])
""",
        encoding="utf-8",
    )
    fields = {
        "part.name": WORD,
        "part.values[0]": -(2**31),
        "strings[0].wide_brief": "äöü",
        "strings[1].few_briefs[1]": "b",
        "own.state": {"min": 255},
        "header.frame_id": {"matches": "^m"},
    }
    service = {"service": "/swap", "type": "type_matrix/srv/Swap", "within": "60 s"}
    expected = [
        {"topic": "/nested", "type": "type_matrix/msg/Nested", "within": "60 s"},
        {"message": "/nested", "fields": fields, "count": ">= 2"},
        {**service, "request": {"word": WORD}, "fields": {"parts[0].name": WORD}},
    ]
    file = tmp_path / "types.expect.yaml"
    file.write_text(yaml.safe_dump({"expect": expected}), encoding="utf-8")
    target = str(tmp_path / "types.launch.py")
    done = patient_launcher(matrix.root, "smoke", target, "sigterm_timeout:=60", **env)
    assert done.code == 0, done.out + done.err
    wrong = [{"message": "/nested", "type": "type_matrix/msg/Nested", "fields": {"part.nam": "x"}}]
    file.write_text(yaml.safe_dump({"expect": wrong}), encoding="utf-8")
    refused = patient_launcher(matrix.root, "smoke", target, **env)
    assert refused.code == 2
    assert "matrix_parts/msg/Part has no field 'nam'" in refused.out + refused.err


HASHES = """
from launcher.ros.messages.interfaces import interfaces_of
from launcher.ros.messages.message_schema import rihs_hash, schema_text
from tests.ros.unit.test_schema import hash_by_rosbags, messages_of
for interface in interfaces_of("type_matrix"):
    for full in messages_of(interface):
        is_known = "wstring" not in schema_text(full)  # rosbags cannot read these
        print(full, hash_by_rosbags(full) == rihs_hash(full) if is_known else rihs_hash(full)[:7])
"""


def test_definitions_have_the_hashes_of_their_types(matrix: BuiltWorkspace, env: dict[str, str]):
    """Of the messages of actions, too: no installed package has one."""
    program = [sys.executable, "-c", HASHES]
    out = run(program, cwd=REPOSITORY, env=matrix.environment(env))
    answers = dict(line.split() for line in out.splitlines() if line.startswith("type_"))
    assert set(answers.values()) == {"True", "RIHS01_"}, out
    assert answers["type_matrix/action/Fold_SendGoal_Event"] == "True"
    assert answers["type_matrix/msg/Nested"] == "RIHS01_"
