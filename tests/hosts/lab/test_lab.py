"""The lab itself: hosts are apart from each other and from the machine, and nothing is left."""

from __future__ import annotations

import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import yaml

from tests.support.hosts import Host, Lab, leftovers, needs_clocks, needs_hosts
from tests.support.hosts.checks import answers, heard, is_reached, killed_run, login, module, traces
from tests.support.hosts.keys import make_key
from tests.support.repository import REPOSITORY
from tests.support.waiting import wait_until


@pytest.fixture(scope="module")
def one(lab: Lab) -> Host:
    return lab.host("one")


@pytest.fixture(scope="module")
def two(lab: Lab) -> Host:
    return lab.host("two")


def test_each_host_has_a_name_an_identity_and_files_of_its_own(one: Host, two: Host):
    for path in ("/dev/shm", "/tmp", "/run"):
        one.run(["touch", f"{path}/mark"])
        assert two.run(["test", "-e", f"{path}/mark"], check=False).returncode == 1
        assert not Path(path, "mark").exists()
    for words in (
        ["hostname"],
        ["cat", "/etc/machine-id"],
        ["cat", "/proc/sys/kernel/random/boot_id"],
        ["sh", "-c", "echo ~root"],
    ):
        texts = {computer.run(words).stdout for computer in (one, two)}
        assert len(texts) == 2
        assert subprocess.run(words, capture_output=True, text=True).stdout not in texts


def test_hosts_see_their_own_processes_only(one: Host, two: Host):
    with one.popen(["sleep", "infinity"]) as process:
        assert process.inside in [found.pid for found in one.processes()]
        assert process.inside not in [found.pid for found in two.processes()]
        seen = one.run(["ps", "-A", "-o", "args"]).stdout
        assert "pytest" not in seen
        process.send_signal(signal.SIGINT)
        assert process.wait() == -signal.SIGINT


def test_a_login_needs_the_key_of_the_user_and_the_key_of_the_host(lab: Lab, one: Host):
    done = login(lab, one, "echo $SSH_CONNECTION; hostname; pwd")
    assert done.stdout.split("\n")[1:3] == ["one", str(one.home)], done.stderr
    other = lab.folder / "other"
    make_key(other)
    wrong = [word.replace(str(lab.key), str(other)) for word in lab.ssh(one, "true")]
    refused = lab.operator.run(wrong, check=False)
    assert refused.returncode == 255
    assert "Permission denied (publickey)" in refused.stderr


def test_a_changed_host_key_is_refused_until_it_is_trusted(lab: Lab):
    host = lab.host("changed")
    assert answers(lab, host)
    host.new_host_key()
    refused = login(lab, host, "true")
    assert refused.returncode == 255
    assert "Host key verification failed" in refused.stderr
    lab.trust(host)
    assert answers(lab, host)


def test_a_link_is_down_until_it_is_up(lab: Lab, two: Host):
    assert answers(lab, two)
    two.link_down()
    assert not is_reached(lab, two)
    two.link_up()
    assert answers(lab, two)


def test_a_link_that_is_up_leaves_no_failed_search_for_the_host(lab: Lab, two: Host):
    """One that began while it was down would end connections with "No route to host"."""
    two.link_down()
    lab.operator.run(["ip", "neigh", "flush", "to", two.address])
    with lab.operator.popen([sys.executable, "-c", _SENDER, two.address]) as process:
        wait_until(lambda: "INCOMPLETE" in neighbour(lab, two), "the operator looks for it")
        two.link_up()
        found = neighbour(lab, two)
        process.kill()
    assert "lladdr" in found


_SENDER = """
import socket, sys, time
while True:
    with socket.socket(type=socket.SOCK_DGRAM) as one:
        one.sendto(b"", (sys.argv[1], 9))
    time.sleep(0.05)
"""


def neighbour(lab: Lab, host: Host) -> str:
    return lab.operator.run(["ip", "neigh", "show", host.address]).stdout


def test_a_host_without_power_has_no_process_and_boots_again(lab: Lab):
    host = lab.host("dark")
    boot = login(lab, host, "cat /proc/sys/kernel/random/boot_id").stdout
    with lab.operator.popen(lab.ssh(host, "exec sleep 1000"), stderr=subprocess.PIPE) as session:
        wait_until(lambda: [x for x in host.processes() if "1000" in x.words], "a session")
        host.power_off()
        assert host.processes() == []
        assert session.poll() is None  # nobody told it
        session.kill()
    assert not is_reached(lab, host)
    host.power_on()
    wait_until(lambda: is_reached(lab, host), "the host answers again")
    assert login(lab, host, "cat /proc/sys/kernel/random/boot_id").stdout != boot


def test_killed_sessions_end_for_the_client_and_sshd_goes_on(lab: Lab, one: Host):
    with lab.operator.popen(lab.ssh(one, "exec sleep 1000"), stderr=subprocess.PIPE) as session:
        wait_until(lambda: [x for x in one.processes() if "1000" in x.words], "a session")
        one.kill_sshd_sessions()
        assert session.wait() == 255
    assert answers(lab, one)


def test_a_killed_sshd_refuses_connections_until_it_is_started(lab: Lab, one: Host):
    one.kill_sshd()
    assert "Connection refused" in login(lab, one, "true").stderr
    one.start_sshd()
    assert answers(lab, one)


def test_a_full_disk_has_room_again_when_it_is_freed(one: Host):
    path = one.home / "data"
    write = ["sh", "-c", 'head -c 10000 /dev/zero > "$1"', "sh", f"{path}/file"]
    one.full_disk(path)
    assert "No space left" in one.run(write, check=False).stderr
    one.free_disk(path)
    one.run(write)


def connection_s(lab: Lab, host: Host) -> float:
    """How long the operator takes to open a connection to sshd."""
    code = f"""import socket, time
start = time.monotonic()
socket.create_connection(("{host.address}", 22), 60).close()
print(time.monotonic() - start)"""
    return float(lab.operator.run([sys.executable, "-c", code]).stdout)


def test_a_slow_link_delays_both_directions_and_changes_nothing(lab: Lab):
    host = lab.host("slow")
    host.slow_link(delay_s=0.05)
    assert connection_s(lab, host) >= 0.1
    copy = f"head -c 2000000 {sys.executable}"
    ways = (copy, shlex.join(lab.ssh(host, copy)))
    sums = [lab.operator.run(["sh", "-c", f"{way} | md5sum"]).stdout for way in ways]
    assert sums[0] == sums[1]
    host.slow_link(loss=1.0)
    assert not is_reached(lab, host)
    host.normal_link()
    wait_until(lambda: is_reached(lab, host), "the host answers again")


def test_a_hosts_file_says_how_to_log_in(lab: Lab, one: Host, two: Host):
    path = lab.folder / "hosts.yaml"
    hosts = {one: {"engine": "ssh"}, two: {}}
    content = yaml.safe_load(lab.hosts_file(path, hosts, {"robot_1": "one"}).read_text())
    assert content["place"] == {"robot_1": "one"}
    assert content["hosts"]["one"] == {**lab.settings(one), "engine": "ssh"}
    assert content["hosts"]["two"]["address"] == two.address


def test_a_host_can_have_another_time(lab: Lab, one: Host):
    needs_clocks()
    ahead = lab.host("ahead", clock_offset_s=3600.0)
    now = f"{sys.executable} -c 'import time; print(time.time())'"
    assert float(login(lab, ahead, now).stdout) - time.time() > 3500.0
    assert heard(ahead, one) >= 0


@pytest.fixture(scope="module")
def quiet(lab: Lab) -> Host:
    return lab.host("quiet", multicast=False)


@pytest.fixture(scope="module")
def far(lab: Lab) -> Host:
    return lab.host("far", routed=True)


def received(sender: Host, *receivers: Host) -> dict[str, list[str]]:
    """What each receiver gets of a multicast datagram and one of its own that follows it."""
    name = "tests.support.hosts.multicast"
    options = {"cwd": REPOSITORY, "stdout": subprocess.PIPE}
    processes = [host.popen(module(name, "receive"), **options) for host in receivers]
    for process in processes:
        assert process.stdout.readline() == "ready\n"
    addresses = [host.address for host in receivers]
    sender.run(module(name, "send", *addresses), cwd=REPOSITORY)
    texts = [process.communicate(timeout=60)[0].split() for process in processes]
    return dict(zip([host.name for host in receivers], texts, strict=True))


def test_multicast_reaches_those_on_the_bridge_only(one: Host, two: Host, quiet: Host, far: Host):
    assert received(one, two, quiet, far) == {
        "two": ["multicast", "end"],
        "quiet": ["end"],
        "far": ["end"],
    }
    for host in (quiet, far):
        assert received(host, one) == {"one": ["end"]}


def test_nodes_find_each_other_by_multicast(one: Host, two: Host):
    assert heard(one, two) >= 0


def test_nodes_find_each_other_by_a_list_of_peers_without_multicast(one: Host, far: Host):
    assert heard(one, far, ROS_STATIC_PEERS=f"{one.address};{far.address}") >= 0


def test_nothing_is_left_of_a_lab():
    needs_hosts()
    with Lab() as lab:
        host = lab.host("one")
        host.popen(["sleep", "infinity"])
        lab.operator.popen(["sleep", "infinity"])
        assert traces(lab.name)
    assert traces(lab.name) == []


def test_the_next_lab_removes_what_a_killed_run_left():
    needs_hosts()
    with killed_run("host") as (name, left):
        assert len(left) > 3
        leftovers.remove_leftovers()
        assert traces(name) == []
