"""The texts of definitions, read back by the parsers of two other projects."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy")

from hypothesis import given, settings
from hypothesis import strategies as st
from mcap_ros2._dynamic import generate_dynamic
from rclpy.serialization import serialize_message
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosidl_adapter.parser import parse_message_string

from launcher.base.ros_errors import VerbError
from launcher.ros.messages.interfaces import all_interfaces, definition_path, load_message
from launcher.ros.messages.message_schema import rihs_hash, schema_text
from tests.support.any_message import messages
from tests.support.examples import examples
from tests.support.interfaces import PACKAGE, SOURCES
from tests.support.repository import REPOSITORY

SEPARATOR = "\n" + "=" * 80 + "\nMSG: "
PARTS = {
    "msg": [""],
    "srv": ["_Request", "_Response", "_Event"],
    "action": [
        *("_Goal", "_Result", "_Feedback", "_FeedbackMessage"),
        *("_SendGoal_Request", "_SendGoal_Response", "_SendGoal_Event"),
        *("_GetResult_Request", "_GetResult_Response", "_GetResult_Event"),
    ],
}


def messages_of(interface: str) -> list[str]:
    return [f"{interface}{part}" for part in PARTS[interface.split("/")[1]]]


INSTALLED = [name for interface in all_interfaces() for name in messages_of(interface)]


def decoder(full: str) -> Any:
    """By another name, since mcap_ros2 refuses X_Event and the like."""
    return generate_dynamic("root/msg/Root", schema_text(full))["root/msg/Root"]


def hash_by_rosbags(full: str) -> str:
    """What rosbags makes of the text; it has `pkg/srv/X_Request` as `pkg/msg/X_Request`."""
    package, kind, name = full.split("/")
    part = f"{package}/msg/{name.partition('_')[0]}_"

    def renamed(value: Any) -> Any:
        if isinstance(value, tuple | list):
            return type(value)(renamed(item) for item in value)
        if value == "char":
            return "uint8"  # as ROS 2 has it
        is_part = isinstance(value, str) and value.startswith(part)
        return value.replace("/msg/", f"/{kind}/") if is_part else value

    store = get_typestore(Stores.EMPTY)
    found = get_types_from_msg(schema_text(full), f"{package}/msg/{name}")
    store.register({renamed(key): renamed(value) for key, value in found.items()})
    return str(store.hash_rihs01(full))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The prefix of a package with an action, and with wide strings.

    Made by another process, since empy keeps the standard output of its first use.
    """
    folder = tmp_path_factory.mktemp("every_kind")
    make = "import pathlib, sys; from tests.support.interfaces import install"
    command = [sys.executable, "-c", f"{make}; install(pathlib.Path(sys.argv[1]))", str(folder)]
    subprocess.run(command, cwd=REPOSITORY, stdout=subprocess.DEVNULL, check=True)
    return folder / "prefix"


@pytest.fixture
def every_kind(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The folder with the definitions of that package, of which a test may remove some."""
    prefix = shutil.copytree(made, tmp_path / "prefix")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(prefix))
    schema_text.cache_clear()
    yield prefix / "share" / PACKAGE
    schema_text.cache_clear()


def test_dependencies_follow_in_order_of_first_use():
    text = schema_text("geometry_msgs/msg/PoseStamped")
    assert [part.partition("\n")[0] for part in text.split(SEPARATOR)[1:]] == [
        "std_msgs/Header",
        "builtin_interfaces/Time",
        "geometry_msgs/Pose",
        "geometry_msgs/Point",
        "geometry_msgs/Quaternion",
    ]
    own = definition_path("geometry_msgs/msg/PoseStamped").read_text(encoding="utf-8")
    assert text.startswith(f"{own}{SEPARATOR}std_msgs/Header\n# Standard metadata")


def test_the_text_of_a_type_without_dependencies_is_its_file():
    path = definition_path("std_msgs/msg/String")
    assert schema_text("std_msgs/msg/String") == path.read_text(encoding="utf-8")
    assert schema_text("std_srvs/srv/Trigger_Request") == ""


def test_sections_of_a_service_are_messages():
    assert schema_text("std_srvs/srv/SetBool_Request").startswith("bool data")
    assert "bool success" in schema_text("std_srvs/srv/SetBool_Response")
    event, *others = schema_text("std_srvs/srv/SetBool_Event").split(SEPARATOR)
    assert event == (
        "service_msgs/ServiceEventInfo info\n"
        "std_srvs/SetBool_Request[<=1] request\n"
        "std_srvs/SetBool_Response[<=1] response\n"
    )
    assert [other.partition("\n")[0] for other in others] == [
        "service_msgs/ServiceEventInfo",
        "builtin_interfaces/Time",
        "std_srvs/SetBool_Request",
        "std_srvs/SetBool_Response",
    ]


def test_mcap_ros2_reads_every_installed_type():
    assert len(INSTALLED) > 200
    for full in INSTALLED:
        assert decoder(full) is not None


@pytest.mark.parametrize("interface", all_interfaces())
def test_the_text_has_the_hash_of_the_type(interface: str):
    for full in messages_of(interface):
        assert hash_by_rosbags(full) == rihs_hash(full)


def as_mcap(value: Any) -> Any:
    """A value of a message as mcap_ros2 has it, comparable."""
    if hasattr(value, "get_fields_and_field_types"):
        names = value.get_fields_and_field_types()
        kept = [name for name in names if name != "structure_needs_at_least_one_member"]
        return {name: as_mcap(getattr(value, name)) for name in kept}
    if isinstance(value, list) and value and isinstance(value[0], bytes):
        return [item[0] for item in value]
    if isinstance(value, str | bytes | int | float):
        return repr(value)
    return [as_mcap(item) for item in value]


def as_read(value: Any) -> Any:
    if hasattr(value, "__slots__") and not isinstance(value, np.ndarray):
        return {name: as_read(getattr(value, name)) for name in value.__slots__}
    if isinstance(value, str | int | float):
        return repr(value)
    return [as_read(item) for item in value]


@pytest.mark.parametrize(
    "full", ["sensor_msgs/msg/JointState", "std_msgs/msg/Empty", "diagnostic_msgs/msg/KeyValue"]
)
@settings(max_examples=examples(50))
@given(data=st.data())
def test_what_rclpy_sends_is_decoded_by_the_text(full: str, data: st.DataObject):
    message = data.draw(messages(load_message(full)))
    assert as_read(decoder(full)(serialize_message(message))) == as_mcap(message)


@pytest.mark.basic  # the generator is slow
def test_every_message_of_an_action(every_kind: Path):
    action = f"{PACKAGE}/action/Fold"
    for full in messages_of(action):
        assert as_ros_reads(full)
        if not full.endswith("_Event"):  # mcap_ros2 refuses fields of the type X_SendGoal_Request
            assert decoder(full) is not None
    assert schema_text(f"{action}_Goal") == "# how often\nint32 order\n"
    goal = schema_text(f"{action}_SendGoal_Request")
    assert goal.startswith(f"unique_identifier_msgs/UUID goal_id\n{PACKAGE}/Fold_Goal goal\n")
    assert goal.endswith(f"{SEPARATOR}{PACKAGE}/Fold_Goal\n# how often\nint32 order\n")
    result = schema_text(f"{action}_GetResult_Response")
    assert [part.partition("\n")[0] for part in result.split(SEPARATOR)] == [
        "int8 status",
        f"{PACKAGE}/Fold_Result",
        f"{PACKAGE}/Inner",
    ]
    event = schema_text(f"{action}_GetResult_Event")
    assert f"{PACKAGE}/Fold_GetResult_Request[<=1] request" in event
    assert f"{SEPARATOR}{PACKAGE}/Fold_GetResult_Request\nunique_identifier_msgs/UUID" in event


def as_ros_reads(full: str) -> list[str]:
    """Each type of the text, by the parser of ROS 2; `char` of .msg is uint8 in IDL."""
    package, _, name = full.split("/")
    own, *others = schema_text(full).split(SEPARATOR)
    named = [other.partition("\n") for other in others]
    texts = [(f"{package}/{name}", own), *((head, text) for head, _, text in named)]
    # the parser has its own check of names, which refuses X_SendGoal_Request and the like
    plain = re.compile(r"(?<=[a-z])_(?=[A-Z])")
    return [
        str(parse_message_string(*plain.sub("", head).split("/"), plain.sub("", text))).replace(
            "char", "uint8"
        )
        for head, text in texts
    ]


@pytest.mark.basic  # the generator is slow
@pytest.mark.parametrize("source", SOURCES)
def test_a_type_that_is_there_only_in_idl_has_the_same_fields(every_kind: Path, source: str):
    interface = f"{PACKAGE}/{source.rpartition('.')[0]}"
    expected = {full: as_ros_reads(full) for full in messages_of(interface)}
    for name in SOURCES:
        (every_kind / name).unlink()
    schema_text.cache_clear()
    for full in messages_of(interface):
        assert as_ros_reads(full) == expected[full]


@pytest.mark.basic  # the generator is slow
def test_idl_keeps_comments_constants_and_defaults(every_kind: Path):
    (every_kind / "msg/Kinds.msg").unlink()
    lines = schema_text(f"{PACKAGE}/msg/Kinds").splitlines()
    assert "# Fields of every kind." in lines
    for line in (
        "int32 LIMIT=7",
        'string GREETING="\\"hello"',  # ROS 2 takes the rest for a comment
        "bool flag true",
        "float32 f32 0.5",
        'string text "default"',
        "string<=5 brief",
        "wstring<=4 wide_brief",
        "byte[3] three_octets",
        "int16[2] pair [1, 2]",
        "string<=3[<=2] few_brief",
        f"{PACKAGE}/Inner[2] two",
    ):
        assert line in lines


IDL = """module every_kind { module msg {
  module Inner_Constants { const string QUOTED = "a \\"b\\""; };
  struct Inner { wchar wide; unsigned short few; sequence<octet> raw; %s };
}; };
"""


@pytest.mark.basic  # the generator is slow
def test_types_that_only_idl_has(every_kind: Path):
    (every_kind / "msg/Inner.msg").unlink()
    (every_kind / "msg/Inner.idl").write_text(IDL % "")
    assert schema_text(f"{PACKAGE}/msg/Inner") == (
        'string QUOTED="a \\"b\\""\nuint16 wide\nuint16 few\nbyte[] raw\n'
    )
    (every_kind / "msg/Inner.idl").write_text(IDL % "long double precise;")
    schema_text.cache_clear()
    with pytest.raises(VerbError, match="have no type 'long double'"):
        schema_text(f"{PACKAGE}/msg/Inner")
    (every_kind / "msg/Inner.idl").write_text(IDL % "union")
    with pytest.raises(VerbError, match=r"Inner.idl cannot be read: "):
        schema_text(f"{PACKAGE}/msg/Inner")


@pytest.mark.parametrize(
    "name",
    ["String", "std_msgs/String", "std_msgs/msg/Strin", "no_msgs/msg/X", "std_srvs/srv/Empty"],
)
def test_what_is_not_installed_is_told(name: str):
    with pytest.raises(VerbError, match=f"no definition of {name} is installed"):
        schema_text(name)


@pytest.mark.parametrize("look_up", [schema_text, load_message])
def test_a_type_that_a_workspace_may_have_is_said_where_to_find(look_up, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("LAUNCHER_WORKSPACE", raising=False)
    said = "types of a workspace are found only in its folder, or with --workspace DIR"
    with pytest.raises(VerbError) as caught:
        look_up("my_robot_interfaces/msg/Count")
    assert (caught.value.hint or "").endswith(said)
    (tmp_path / "install").mkdir()
    (tmp_path / "install" / ".colcon_install_layout").write_text("isolated")
    with pytest.raises(VerbError) as caught:
        look_up("my_robot_interfaces/msg/Count")
    assert said not in (caught.value.hint or "")
    with pytest.raises(VerbError) as caught:
        look_up("std_msgs/msg/Nothing")
    assert said not in (caught.value.hint or "")


@pytest.mark.basic  # the generator is slow
def test_a_missing_dependency_is_told(every_kind: Path):
    index = every_kind.parent / "ament_index/resource_index/rosidl_interfaces" / PACKAGE
    index.write_text(index.read_text().replace("msg/Inner.idl", ""))
    with pytest.raises(VerbError, match=f"Kinds needs {PACKAGE}/msg/Inner, which is not installed"):
        schema_text(f"{PACKAGE}/msg/Kinds")


def test_hashes_of_services_and_their_messages():
    for name in ("SetBool", "SetBool_Request", "SetBool_Response", "SetBool_Event"):
        assert rihs_hash(f"std_srvs/srv/{name}").startswith("RIHS01_")
    assert rihs_hash("std_msgs/msg/String") == (
        "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
    )


@pytest.mark.basic  # the generator is slow
def test_a_hash_that_is_not_installed_is_told(every_kind: Path):
    with pytest.raises(
        VerbError, match=r"the hash of every_kind/msg/Inner is not installed: .*json"
    ):
        rihs_hash(f"{PACKAGE}/msg/Inner")
