"""Values of ROS_DOMAIN_ID that rcl accepts, and nodes that are refused for a bad one."""

import pytest

from launcher.base.errors import UsageError
from launcher.base.model.events import StartProcess
from launcher.base.model.spec import ProcessSpec, RosIdentity
from launcher.launch.launch_checks import refuse_domain
from launcher.posix.domains import is_domain

GOOD = ["", "0", "00", "-0", "232", " 7", "+7", "0x10", "010", "5abc"]
BAD = ["abc", " ", "233", "-1", "0 ", "08", "0xg", "0x", ".5", "4294967301", "٣"]


@pytest.mark.parametrize("word", GOOD)
def test_values_that_rcl_accepts_are_valid_domains(word):
    assert is_domain(word)


@pytest.mark.parametrize("word", BAD)
def test_values_that_rcl_rejects_are_invalid_domains(word):
    assert not is_domain(word)


def start(name: str, domain: str, ros: RosIdentity | None) -> StartProcess:
    spec = ProcessSpec(name=name, label=name, argv=("x",), env={"ROS_DOMAIN_ID": domain}, ros=ros)
    return StartProcess(process_id=1, spec=spec)


NODE = RosIdentity(node_name="x")


def test_nodes_with_an_invalid_domain_are_named():
    effects = [start(f"node-{number}", "abc", NODE) for number in range(1, 6)]
    with pytest.raises(UsageError, match="ROS_DOMAIN_ID is 'abc'") as caught:
        refuse_domain("abc", effects)
    assert "(node-1, node-2, node-3 and 2 more)" in caught.value.message
    assert "export ROS_DOMAIN_ID=0" in str(caught.value.hint)


def test_processes_with_their_own_domain_and_non_nodes_are_not_refused():
    refuse_domain("abc", [start("node-1", "5", NODE), start("sh-2", "abc", None)])
    refuse_domain("7", [start("node-1", "7", NODE)])
