"""Values of ROS_DOMAIN_ID, as rcl reads them, and who is refused for one."""

import pytest

from launcher.commands.launch.checks import refuse_domain
from launcher.errors import UsageError
from launcher.model.events import StartProcess
from launcher.model.spec import ProcessSpec, RosIdentity
from launcher.ros.discovery.domains import is_domain

GOOD = ["", "0", "00", "-0", "232", " 7", "+7", "0x10", "010", "5abc"]
BAD = ["abc", " ", "233", "-1", "0 ", "08", "0xg", "0x", ".5", "4294967301", "٣"]


@pytest.mark.parametrize("word", GOOD)
def test_what_a_node_takes_as_a_domain_is_one(word):
    assert is_domain(word)


@pytest.mark.parametrize("word", BAD)
def test_what_no_node_takes_as_a_domain_is_none(word):
    assert not is_domain(word)


def start(name: str, domain: str, ros: RosIdentity | None) -> StartProcess:
    spec = ProcessSpec(name=name, label=name, argv=("x",), env={"ROS_DOMAIN_ID": domain}, ros=ros)
    return StartProcess(process_id=1, spec=spec)


NODE = RosIdentity(node_name="x")


def test_nodes_that_would_die_are_named():
    effects = [start(f"node-{number}", "abc", NODE) for number in range(1, 6)]
    with pytest.raises(UsageError, match="ROS_DOMAIN_ID is 'abc'") as caught:
        refuse_domain("abc", effects)
    assert "(node-1, node-2, node-3 and 2 more)" in caught.value.message
    assert "export ROS_DOMAIN_ID=0" in str(caught.value.hint)


def test_who_has_a_domain_of_its_own_or_is_no_node_is_no_reason_to_refuse():
    refuse_domain("abc", [start("node-1", "5", NODE), start("sh-2", "abc", None)])
    refuse_domain("7", [start("node-1", "7", NODE)])
