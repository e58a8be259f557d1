"""`hosts check` on hosts with sshd: each problem is made, found, and told with its repair."""

from __future__ import annotations

import json
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
import yaml

import launcher
from tests.support.hosts import Computer, Host, Lab, needs_clocks, needs_robots
from tests.support.hosts.checks import module
from tests.support.hosts.keys import make_key
from tests.support.hosts.requirements import program
from tests.support.waiting import wait_until

NO_SHARED_MEMORY = "FASTDDS_BUILTIN_TRANSPORTS"


@pytest.fixture(scope="module")
def one(lab: Lab) -> Host:
    return lab.host("one")


@pytest.fixture(scope="module")
def two(lab: Lab) -> Host:
    return lab.host("two")


class Check:
    """Runs `hosts check` on the operator's computer."""

    def __init__(self, lab: Lab, folder: Path) -> None:
        self.lab = lab
        self.file = folder / "hosts.yaml"

    def write(self, hosts: Any, place: Mapping[str, str] = {}, **top: Any) -> Path:
        return self.lab.hosts_file(self.file, hosts, place, **top)

    def text(self, *words: object, **options: Any) -> subprocess.CompletedProcess[str]:
        patient = ("hosts", "check", "--hosts", self.file, "--timeout", "60")
        done = self.lab.operator.launcher(*patient, *words, **options)
        assert "Traceback" not in done.stderr
        return done

    def document(self, *words: object, **options: Any) -> dict[str, Any]:
        done = self.text("--json", *words, **options)
        assert done.stdout, done.stderr
        document: dict[str, Any] = json.loads(done.stdout)
        assert done.returncode == (0 if document["well"] else 1)
        return {**document, "hosts": {one["name"]: one for one in document["hosts"]}}

    def problems(self, *words: object, **options: Any) -> list[tuple[str, list[str], str, str]]:
        """(check, hosts, text, repair) of what is a problem."""
        findings = self.document(*words, **options)["findings"]
        assert all(finding["advice"] for finding in findings)
        return [
            (one["check"], sorted(one["hosts"]), one["text"], one["advice"])
            for one in findings
            if one["level"] == "problem"
        ]


@pytest.fixture
def check(lab: Lab, tmp_path: Path) -> Check:
    return Check(lab, tmp_path)


def test_three_hosts_without_a_problem(check: Check, lab: Lab, one: Host, two: Host):
    check.write([one, two], {"robot_1": "one", "robot_2": "two"})
    done = check.text("group_gp1", "system.launch.py")
    assert done.returncode == 0, done.stdout
    assert done.stdout.endswith("2 hosts: no problem\n")
    rows = {line.split()[0]: line for line in done.stdout.splitlines() if line}
    for name in ("local", "one", "two"):
        assert "unicast 2/2, multicast 2/2" in rows[name]
        assert launcher.__version__ in rows[name]
    assert "all found" in rows["one"]
    assert [found.words for found in one.processes() if "sshd" not in found.words[0]] == []


def test_the_facts_of_a_host_are_those_of_that_host(check: Check, one: Host):
    check.write([one])
    begun_s = time.monotonic()
    document = check.document()
    took_s = time.monotonic() - begun_s
    host = document["hosts"]["one"]
    assert host["reached"] and host["engine"] == "ssh" and host["user"] == "root"
    assert host["addresses"] == [one.address]
    assert host["python"] == ".".join(map(str, sys.version_info[:3]))
    assert 0 < host["login_s"] < took_s
    assert abs(host["clock_offset_s"]) <= host["clock_uncertainty_s"] + 0.001
    assert {folder["path"] for folder in host["folders"]} >= {"/dev/shm", ".ros/log"}
    assert document["network"] == {"unicast": [], "multicast": []}


def test_an_unreachable_host_delays_no_other(check: Check, lab: Lab, one: Host, two: Host):
    gone = lab.host("gone")
    check.write([one, gone, two])
    gone.power_off()
    document = check.document()
    hosts = document["hosts"]
    assert hosts["one"]["reached"] and hosts["two"]["reached"] and not hosts["gone"]["reached"]
    assert document["network"] == {"unicast": [], "multicast": []}
    (finding,) = document["findings"]
    assert (finding["check"], finding["hosts"]) == ("reach", ["gone"])


def test_a_host_without_sshd_a_wrong_key_and_a_changed_one_are_told_apart(
    check: Check, lab: Lab, one: Host, tmp_path: Path
):
    silent = lab.host("silent")
    silent.kill_sshd()
    changed = lab.host("changed")
    changed.new_host_key()
    make_key(tmp_path / "other_key")
    other = {"IdentityFile": str(tmp_path / "other_key"), "IdentitiesOnly": "yes"}
    options = {**lab.ssh_options(), **other}
    check.write({silent: {}, changed: {}, one: {"ssh": options}})
    problems = {names[0]: (text, repair) for _, names, text, repair in check.problems()}
    assert "refuses connections" in problems["silent"][0]
    assert "host key has changed" in problems["changed"][0]
    assert "ssh-keygen" in problems["changed"][1]
    assert "login as root was refused" in problems["one"][0]


def test_no_python_and_no_launcher(check: Check, one: Host, two: Host):
    bare = shutil.which("python3", path="/usr/bin")
    assert bare is not None
    (two.home / "bare.sh").write_text("unset PYTHONPATH\n")
    check.write({one: {"python": "no/such/python"}, two: {"python": bare, "setup": "bare.sh"}})
    problems = {names[0]: (kind, text, repair) for kind, names, text, repair in check.problems()}
    assert problems["one"][:2] == ("reach", "there is no Python 'no/such/python'")
    found = [(text, repair) for kind, *_, text, repair in check.problems() if kind == "launcher"]
    assert found == [
        (
            f"{bare} has no launcher",
            f"python -m launcher hosts sync --hosts {check.file} installs it",
        )
    ]


def test_a_launcher_of_another_version_is_told(check: Check, two: Host):
    folder = two.home / "other"
    (folder / "launcher/hosts/file").mkdir(parents=True)
    (folder / "launcher/__init__.py").write_text('__version__ = "0.0.1"\n')
    (folder / "launcher/hosts/__init__.py").touch()
    identity = "PROTOCOL = 0\ndef code_id():\n    return 'other'\n"
    (folder / "launcher/hosts/identity.py").write_text(identity)
    check.write({two: {"setup": "other.sh"}})
    (two.home / "other.sh").write_text(f"export PYTHONPATH={folder}\n")
    found = [(text, repair) for kind, _, text, repair in check.problems() if kind == "launcher"]
    ((text, repair),) = found
    known = f"launcher 0.0.1 is installed, and {launcher.__version__} runs here"
    assert text == f"{known}: they use different protocols"
    assert "hosts sync" in repair


def test_what_the_plan_needs_and_the_host_does_not_have_is_named(
    check: Check, two: Host, tmp_path: Path
):
    prefix = package(tmp_path / "prefix", "drill", "bore", depends="drill_msgs")
    package(prefix, "drill_msgs", interfaces=True)
    launch_file = tmp_path / "drill.launch.yaml"
    launch_file.write_text("launch:\n- node: {pkg: drill, exec: bore, name: bore}\n")
    check.write([two], {"bore": "two"})
    env = {"AMENT_PREFIX_PATH": f"{prefix}:{sys.prefix}"}
    found = [one for one in check.problems(launch_file, env=env) if one[0] == "packages"]
    ((_, names, text, repair),) = found
    assert (names, text) == (["two"], "not found: package drill, message package drill_msgs")
    assert repair.endswith(f"hosts sync --hosts {check.file}")


def package(
    prefix: Path, name: str, executable: str = "", *, depends: str = "", interfaces: bool = False
) -> Path:
    """An installed package, by the files of ament."""
    index = prefix / "share/ament_index/resource_index"
    for kind in ("packages", *["rosidl_interfaces"] * interfaces):
        (index / kind).mkdir(parents=True, exist_ok=True)
        (index / kind / name).touch()
    share = prefix / "share" / name
    share.mkdir()
    depend = f"<exec_depend>{depends}</exec_depend>" if depends else ""
    (share / "package.xml").write_text(f"<package><name>{name}</name>{depend}</package>\n")
    if executable:
        (prefix / "lib" / name).mkdir(parents=True)
        (prefix / "lib" / name / executable).write_text("#!/bin/sh\n")
        (prefix / "lib" / name / executable).chmod(0o755)
    return prefix


def test_blocked_multicast_is_found_and_is_no_problem_with_peers(check: Check, lab: Lab, one: Host):
    quiet = lab.host("quiet", multicast=False)
    check.write([one, quiet])
    ((kind, names, text, repair),) = check.problems()
    assert (kind, names) == ("discovery", ["local", "one", "quiet"])
    assert text.startswith("multicast is blocked: ")
    assert "one <-> quiet" in text and "one <-> local" not in text
    assert "--discovery peers" in repair
    assert check.problems("--discovery", "peers") == []
    assert check.problems("--discovery", "server") == []


def test_a_firewall_that_stops_udp_is_found(check: Check, one: Host, two: Host):
    iptables = program("iptables")
    if iptables is None:
        pytest.skip("not installed: iptables")
    rule = ["INPUT", "-p", "udp", "-s", two.address, "-j", "DROP"]
    if one.run([iptables, "-A", *rule], check=False).returncode:
        pytest.skip("the kernel has no iptables")
    try:
        check.write([one, two])
        ((kind, names, text, repair),) = check.problems("--discovery", "peers")
    finally:
        one.run([iptables, "-D", *rule])
    assert (kind, names) == ("discovery", ["one", "two"])
    assert "two -> one" in text and "one -> two" not in text
    assert repair.startswith("open UDP from port ")


def test_settings_that_keep_nodes_on_their_host(check: Check, one: Host):
    check.write({one: {"environment": {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}}})
    ((kind, names, text, repair),) = check.problems()
    assert (kind, names) == ("discovery", ["one"])
    assert "find none of other hosts" in text and "--discovery peers" in repair
    assert check.problems(env={"ROS_LOCALHOST_ONLY": "1"}) != []


def test_another_domain_is_found(check: Check, one: Host, two: Host):
    check.write({one: {"environment": {"ROS_DOMAIN_ID": "5"}}, two: {}})
    ((kind, names, text, _),) = check.problems(env={"ROS_DOMAIN_ID": "7"})
    assert (kind, names) == ("domain", ["local", "one", "two"])
    assert text.startswith("ROS_DOMAIN_ID is 7 on local and two, 5 on one")


def test_another_middleware_is_found(check: Check, one: Host):
    check.write({one: {"environment": {"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}}})
    texts = [text for kind, _, text, _ in check.problems() if kind == "middleware"]
    assert len(texts) == 2
    assert any("not installed" in text for text in texts)
    assert any("rmw_fastrtps_cpp on local, rmw_cyclonedds_cpp on one" in text for text in texts)


def test_another_distribution_is_found(check: Check, one: Host):
    prefix = one.home / "humble"
    if not prefix.exists():
        package(prefix, "rclpy")
    manifest = prefix / "share/rclpy/package.xml"
    manifest.write_text("<package><name>rclpy</name><version>3.3.11</version></package>\n")
    (one.home / "humble.sh").write_text(f"export AMENT_PREFIX_PATH={prefix}\n")
    check.write({one: {"setup": "humble.sh"}})
    ((kind, names, text, _),) = check.problems()
    assert (kind, names) == ("distro", ["local", "one"])
    assert "jazzy on local, humble on one" in text


def test_a_full_disk_is_found(check: Check, two: Host):
    two.run(["mkdir", "-p", f"{two.home}/.ros/log"])
    two.full_disk(f"{two.home}/.ros/log")
    try:
        check.write([two])
        kinds = {kind for kind, *_ in check.problems()}
    finally:
        two.run(["umount", f"{two.home}/.ros/log"])
    assert kinds == {"disk"}


def test_few_sessions_are_found(check: Check, lab: Lab):
    narrow = lab.host("narrow")
    narrow.run(["sh", "-c", 'echo "MaxSessions 1" >> /etc/ssh/sshd_config'])
    check.write([narrow])
    ((kind, _, text, _),) = check.problems()
    assert kind == "sessions"
    assert text == "sshd allows 1 session on a connection (MaxSessions)"


@pytest.mark.parametrize(("offset_s", "level"), [(0.3, "note"), (-40.0, "problem")])
def test_a_clock_that_is_off_is_found(check: Check, lab: Lab, offset_s: float, level: str):
    needs_clocks()
    host = lab.host(f"clock-{level}", clock_offset_s=offset_s)
    check.write([host])
    document = check.document()
    (finding,) = [one for one in document["findings"] if one["check"] == "clock"]
    assert finding["level"] == level
    found = document["hosts"][host.name]
    assert abs(found["clock_offset_s"] - offset_s) <= found["clock_uncertainty_s"] + 0.05
    assert ("ahead of" if offset_s > 0 else "behind") in finding["text"]


def test_the_engine_is_systemd_where_the_host_has_it(check: Check, lab: Lab, one: Host):
    needs_robots()
    robot = lab.robot("robot")
    check.write({robot: {}, one: {"engine": "systemd"}})
    document = check.document()
    assert document["hosts"]["robot"]["engine"] == "systemd"
    assert document["hosts"]["robot"]["systemd"]
    problems = {
        one["hosts"][0]: one["text"] for one in document["findings"] if one["check"] == "engine"
    }
    assert problems == {"one": "engine is systemd, but the machine was not booted with systemd"}


# ---- containers with the network of their host


@pytest.fixture
def container(lab: Lab, one: Host) -> Iterator[dict[str, Any]]:
    """The settings of a container with the addresses of a host, and a /dev/shm of its own."""
    port = 2222
    line = f"[{one.address}]:{port} {one.public_key}\n"
    with lab.known_hosts.open("a", encoding="ascii") as file:
        file.write(line)
    mount = "mount -t tmpfs -o mode=1777 tmpfs /dev/shm"
    sshd = f"{program('sshd')} -D -p {port} -o PidFile=none -f {one.folder}/sshd_config"
    command = [
        "unshare",
        "--mount",
        "--propagation",
        "private",
        "sh",
        "-c",
        f"{mount}; exec {sshd}",
    ]
    with one.popen(command) as process:
        wait_until(lambda: is_listening(one, port), "the container's sshd listens")
        yield {**lab.settings(one), "ssh": {**lab.ssh_options(), "Port": port}}
        process.kill()
    others = lab.known_hosts.read_text(encoding="ascii").replace(line, "")
    lab.known_hosts.write_text(others, encoding="ascii")


def is_listening(host: Computer, port: int) -> bool:
    done = host.run(["cat", "/proc/net/tcp"])
    return f":{port:04X} 00000000:0000 0A" in done.stdout


def test_two_hosts_with_one_address_and_two_shared_memories_are_found(
    check: Check, lab: Lab, one: Host, container: dict[str, Any]
):
    def problems(extra: Mapping[str, str]) -> list[Any]:
        hosts = {"one": {**lab.settings(one), "environment": {**extra}}}
        hosts["box"] = {**container, "environment": {**extra}}
        check.file.write_text(yaml.safe_dump({"hosts": hosts, "place": {}}))
        return check.problems()

    ((kind, names, text, repair),) = problems({})
    assert (kind, names) == ("shared memory", ["box", "one"])
    assert one.address in text and "lost without a word" in text
    assert f"{NO_SHARED_MEMORY}=UDPv4" in repair
    assert problems({NO_SHARED_MEMORY: "UDPv4"}) == []


# ---- bad input


def test_bad_files_and_words_are_usage_errors(check: Check, lab: Lab, one: Host):
    assert check.text().returncode == 2  # there is no file yet
    check.write([one], {"robot_9": "one"})
    done = check.text("group_gp1", "system.launch.py")
    assert done.returncode == 2 and "robot_9" in done.stderr
    done = lab.operator.launcher("hosts", "check")
    assert done.returncode == 2 and "there is no hosts.yaml here" in done.stderr
    done = check.text("--discovery", "gossip")
    assert done.returncode == 2 and "'gossip' is not one of" in done.stderr


def test_no_value_of_the_environment_is_shown(check: Check, lab: Lab, one: Host):
    check.write({one: {"environment": {"FLEET_TOKEN": "hush-hush"}}})
    watch = "for i in $(seq 40); do cat /proc/*/cmdline 2>/dev/null; sleep 0.05; done"
    with one.popen(["sh", "-c", watch], stdout=subprocess.PIPE) as watcher:
        shown = check.text("--json").stdout + check.text().stdout
        seen = watcher.communicate(timeout=60)[0]
    assert "hush-hush" not in shown + seen


# ---- the doctor on one host


def doctor(host: Host, **env: str) -> dict[str, dict[str, str]]:
    """Findings about discovery, by name."""
    done = host.run([sys.executable, "-m", "launcher", "doctor", "--json"], env=env, check=False)
    return {finding["check"]: finding for finding in json.loads(done.stdout)["findings"]}


def test_doctor_tries_multicast(one: Host):
    assert doctor(one)["multicast"]["level"] == "ok"
    iptables = program("iptables")
    rule = ["OUTPUT", "-d", "239.255.0.1", "-j", "DROP"]
    if iptables is None or one.run([iptables, "-A", *rule], check=False).returncode:
        pytest.skip("there is no iptables")
    try:
        blocked = doctor(one)["multicast"]
    finally:
        one.run([iptables, "-D", *rule])
    assert blocked["level"] == "problem"
    assert one.address in blocked["text"]


def test_doctor_names_the_domain_of_running_nodes(one: Host):
    words = module("tests.support.hosts.acquaintance", "talker")
    env = {"ROS_DOMAIN_ID": "17"}
    with one.popen(words, env=env, stdout=subprocess.PIPE) as node:
        assert node.stdout is not None and node.stdout.readline() == "talker\n"
        other, same = (doctor(one, ROS_DOMAIN_ID=domain)["other nodes"] for domain in ("3", "17"))
        node.send_signal(signal.SIGINT)
        node.communicate(timeout=60)
    assert other["level"] == "note"
    assert other["text"] == "ROS_DOMAIN_ID is 3, but running nodes use 17"
    assert (same["level"], same["text"]) == ("ok", "1 process with nodes on domain 17")
