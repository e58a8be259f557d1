"""Every mistake of a hosts file with its message; no text makes a traceback."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from launcher.base.errors import LauncherError, SeveralErrors
from launcher.hosts.file import hosts_reader
from launcher.hosts.file.hosts_model import HostsFile
from launcher.hosts.file.ssh_options import KNOWN, REFUSED

GOOD = "hosts: {bot1: 10.0.0.2}\n"


def mistakes(text: str) -> list[str]:
    """`LINE:COLUMN message [| hint]` of each."""
    with pytest.raises(LauncherError) as caught:
        hosts_reader.parse(text, "hosts.yaml", {"SET": "1"})
    error = caught.value
    found = error.errors if isinstance(error, SeveralErrors) else (error,)
    assert {one.exit_code for one in found} == {2}
    return [shown(one) for one in found]


def shown(error: LauncherError) -> str:
    path, _, line = str(error.where).partition(":")
    assert path == "hosts.yaml"
    hint = f" | {error.hint}" if error.hint else ""
    return f"{line}:{error.column or ''} {error.message}{hint}"


# Entries of a host behind `address: b`, and the mistake; the column counts from the entry.
OF_HOST = {
    "adress: c": "1 unknown key 'adress' of host 'a' | did you mean 'address'?",
    "user: -l root": "7 '-l root' is not a user name: expected one such as robot",
    "user: [x]": "7 this is not a user name: expected one such as robot",
    "user: 'a;b'": "7 'a;b' is not a user name: expected one such as robot",
    "engine: docker": "9 'docker' is not one of auto, ssh, systemd",
    "engine: sytemd": "9 'sytemd' is not one of auto, ssh, systemd | did you mean 'systemd'?",
    "python: ''": "9 expected a path on the host",
    "python: -m": "9 '-m' is not a path that the host can use | "
    "paths are absolute, or relative to the home of the user there",
    "python: ~bob/bin/python": "9 '~bob/bin/python' is not a path that the host can use | "
    "paths are absolute, or relative to the home of the user there",
    'python: "a\\nb"': "9 a path on the host has a control character",
    "python: {a: b}": "9 expected a path on the host",
    "python: a, venv: b": "12 'python' and 'venv' exclude each other | "
    "a virtual environment contains a Python interpreter",
    "setup: [a.sh, /opt/ros/jazzy/setup.bash]": "15 '/opt/ros/jazzy/setup.bash' needs bash, "
    "and a POSIX shell reads it | use /opt/ros/jazzy/setup.sh",
    "setup: setup.zsh": "8 'setup.zsh' needs zsh, and a POSIX shell reads it | use setup.sh",
    "on_link_loss: kep": "15 'kep' is not keep, or stop-after= with a time, as in "
    "stop-after=10 s | did you mean 'keep'?",
    "on_link_loss: stop-after=soon": "15 'stop-after=soon' is not keep, or stop-after= with a "
    "time, as in stop-after=10 s | did you mean 'stop-after=10 s'?",
    "on_link_loss: stop-after=900 ms": "15 'stop-after=900 ms' is too short: at least 1 s",
    "on_link_loss: -3 s": "15 '-3 s' is not keep, or stop-after= with a time, as in "
    "stop-after=10 s",
    "environment: [A=1]": "14 expected variables by name, as in {ROS_DOMAIN_ID: 7}",
    "environment: {1A: x}": "15 '1A' is not a name",
    "environment: {A: [1]}": "18 expected the value of a variable | "
    "as in 7, {from_environment: FLEET_TOKEN} or {from_file: ~/.config/fleet.token}",
    "environment: {A: {from_env: B}}": "19 unknown source 'from_env' | "
    "known: from_environment, from_file",
    "environment: {A: {from_environment: }}": "37 'from_environment' needs a name",
    "environment: {A: {from_environment: B}}": "18 the environment has no variable 'B' | "
    "set it for the launcher: B=... launcher ...",
    "environment: {A: {from_file: /none}}": "18 cannot read '/none': No such file or directory",
    "environment: {A: {from_file: /}}": "18 cannot read '/': Is a directory",
    "node_selector: x": "16 expected labels of a node, as in {robot: bot1}",
    "node_selector: {a b: c}": "17 'a b' is not a name",
    "ssh: [Port]": "6 expected options of ssh by name | "
    "as in {Port: 22, IdentityFile: ~/.ssh/fleet}",
    "ssh: {Prot: 22}": "7 unknown ssh option 'Prot' | did you mean 'Port'?",
    "ssh: {Xyzzy: 22}": "7 unknown ssh option 'Xyzzy' | see ssh_config(5)",
    "ssh: {Port: 0}": "13 '0' is not a port: expected 1 to 65535",
    "ssh: {Port: 1, port: 2}": "16 ssh option 'Port' is given twice",
    "ssh: {IdentityFile: }": "21 ssh option 'IdentityFile' needs a value",
    'ssh: {IdentityFile: "a\\nb"}': "21 ssh option 'IdentityFile' has a control character",
    "ssh: {StrictHostKeyChecking: no}": "30 'no' would trust a machine that pretends to be the "
    "host | yes (the default), or accept-new, which trusts a host the first time",
    "ssh: {controlpath: x}": "7 ssh option 'ControlPath' cannot be set: "
    "the launcher opens a separate master connection to each host",
}


@pytest.mark.parametrize("entries", OF_HOST)
def test_mistakes_in_the_entries_of_a_host(entries: str):
    before = "hosts: {a: {address: b, "
    column, _, message = OF_HOST[entries].partition(" ")

    assert mistakes(f"{before}{entries}}}}}\n") == [f"1:{len(before) + int(column)} {message}"]


@pytest.mark.parametrize("name", REFUSED)
def test_options_that_would_break_the_connection_are_refused_with_the_reason(name: str):
    (found,) = mistakes(f"hosts: {{a: {{address: b, ssh: {{{name}: x}}}}}}\n")

    assert f"ssh option '{name}' cannot be set: {REFUSED[name]}" in found


@pytest.mark.parametrize("value", ["no", "off", "ask", '"no"', " no", "=no", "No "])
def test_the_check_of_host_keys_cannot_be_switched_off(value: str):
    entry = f"StrictHostKeyChecking: '{value}'"
    (found,) = mistakes(f"hosts: {{a: {{address: b, ssh: {{{entry}}}}}}}\n")

    assert f"'{value}' would trust a machine that pretends to be the host" in found


def with_known_hosts(value: str) -> str:
    """A hosts file that takes new keys, and keeps them there."""
    new = "ssh: {StrictHostKeyChecking: accept-new}"
    own = f"ssh: {{userknownhostsfile: '{value}'}}"
    return f"defaults: {{{new}}}\nhosts: {{a: {{address: b, {own}}}}}\n"


@pytest.fixture
def known_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory and home, with files that keep keys and others that do not."""
    for name in ("folder", "folder/deep"):
        (tmp_path / name).mkdir()
    (tmp_path / "file").touch()
    os.mkfifo(tmp_path / "fifo")
    links = {"null": "/dev/null", "again": "null", "loop": "loop", "dev": "/dev", "new": "folder/x",
             "input": "/dev/stdin", "gone": "nowhere/x"}  # fmt: skip
    for name, target in links.items():
        (tmp_path / name).symlink_to(target)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("DEVICES", "/dev")
    return tmp_path


@pytest.mark.parametrize(
    "known",
    [
        "/dev/null", "none", "NONE", '"/dev/null"', "/dev/null ~/known", "/dev/./null",
        "//dev/null", "/dev/../dev/null", "/dev/full", "/dev/zero", "/dev/stdin", "/dev/fd/3",
        "/proc/self/fd/0", "/proc/self/comm", "/sys/x", "null", "~/again", "dev/null", "%d/null",
        "${DEVICES}/null", '"/dev"/null', "folder", "fifo", "loop", "input", "gone",
        "nowhere/known", "=/dev/null", "/dev/%h", "/etc/hostname/x",
    ],
)  # fmt: skip
def test_a_host_cannot_be_trusted_anew_each_time(known_files: Path, known: str):
    text = with_known_hosts(known)
    (found,) = mistakes(text)

    assert "would trust any machine each time" in found
    assert f"'{known}' keeps nothing" in found
    hosts_reader.parse(text.replace("accept-new", "yes"), "hosts.yaml", {})


@pytest.mark.parametrize(
    "known",
    [
        "~/.ssh/fleet_hosts", "file", "~/file /dev/null", "new", "folder/deep/../known", "%d/%h",
        "folder/%r/known", '"folder/with a blank"', "/dev/shm/known", "#", "~/known",
    ],
)  # fmt: skip
def test_keys_may_be_kept_in_any_file_that_can_be_written(known_files: Path, known: str):
    hosts_reader.parse(with_known_hosts(known), "hosts.yaml", {})


def test_an_option_is_either_known_or_refused():
    assert not {*KNOWN} & {*REFUSED}
    assert len({*KNOWN}) == len(KNOWN)


ADDRESSES = {
    "10.0.0.300": "'10.0.0.300' is not an IP address: "
    "Octet 300 (> 255) not permitted in '10.0.0.300'",
    "10.0": "'10.0' is not an IP address: Expected 4 octets in '10.0'",
    "robot@bot1": "'robot@bot1' has a user in the address | "
    "write 'address: bot1' and 'user: robot'",
    "robot@bot1:22": "'robot@bot1:22' has a user in the address | "
    "write 'address: bot1', 'user: robot' and 'ssh: {Port: 22}'",
    "'[fd00::1]:22'": "'[fd00::1]:22' has a port in the address | "
    "write 'address: fd00::1' and 'ssh: {Port: 22}'",
    "'@'": "'@' has a user in the address | "
    "write 'address: ...'; `user` and `ssh: {Port: ...}` are separate keys",
    "ssh://bot1": "'ssh://bot1' is a URL: only the name or the address stands here | "
    "write 'address: bot1'; `user` and `ssh: {Port: ...}` are separate keys",
    "ssh://robot:password@10.0.0.2:2222/": "'ssh://robot:password@10.0.0.2:2222/' is a URL: only "
    "the name or the address stands here | "
    "write 'address: 10.0.0.2', 'user: robot' and 'ssh: {Port: 2222}'",
    "bot1:22": "'bot1:22' has a port in the address | write 'address: bot1' and 'ssh: {Port: 22}'",
    "'[fd00::1]'": "'[fd00::1]' has brackets: an IPv6 address stands without them here",
    "fd00::1::2": "'fd00::1::2' is not an IP address: At most one '::' permitted in 'fd00::1::2'",
    "-oProxyCommand=x": "'-oProxyCommand=x' is not a host name or an IP address",
    "'a b'": "'a b' is not a host name or an IP address",
    "a..b": "'a..b' is not a host name or an IP address",
    "{x: y}": "expected an address, as in 10.0.0.2, robot.local or fd00::2",
}


@pytest.mark.parametrize("address", ADDRESSES)
def test_mistakes_in_an_address(address: str):
    assert mistakes(f"hosts:\n  a: {{address: {address}}}\n") == [f"2:16 {ADDRESSES[address]}"]


OF_FILE = {
    "": ": the hosts file is empty | as in 'hosts: {bot1: {address: 10.0.0.2}}'",
    "[1]": "1:1 a hosts file must be a mapping | it begins with 'hosts:'",
    "place: {a: local}": "1:1 a hosts file needs 'hosts' | as in 'bot1: {address: 10.0.0.2}'",
    "hosts: {}": "1:1 'hosts' must be a mapping of names to hosts | "
    "as in 'bot1: {address: 10.0.0.2}'",
    "hosts: [a]": "1:1 'hosts' must be a mapping of names to hosts | "
    "as in 'bot1: {address: 10.0.0.2}'",
    "hosts: {local: a}": "1:9 'local' is the machine of the launcher, and needs no entry",
    "hosts: {a b: c}": "1:9 'a b' is not a name of a host | letters, digits, '_', '-' and '.'",
    "hosts: {a: }": "1:9 host 'a' must be a mapping, or its address | "
    "as in 'a: {address: 10.0.0.2}'",
    "hosts: {a: {user: b}}": "1:9 host 'a' needs an address | as in 'a: {address: 10.0.0.2}'",
    "hosts: {a: b, a: c}": "1:15 duplicate key 'a'",
    "hosts: {a: {address: b, address: c}}": "1:25 duplicate key 'address'",
    "hosts:\n\ta: b": "2:1 invalid YAML: found character that cannot start any token | "
    "indent YAML with spaces, not with tabs",
    f"{GOOD}# caf\xe9 \0": "2:8 invalid YAML: the character U+0000 is not allowed | "
    "remove it; is this file a text in UTF-8?",
    f"{GOOD}# \x85\n\ud800": "3:1 invalid YAML: the character U+D800 is not allowed | "
    "remove it; is this file a text in UTF-8?",
    f"{GOOD}palce: {{x: bot1}}": "2:1 unknown key 'palce' of a hosts file | "
    "did you mean 'place'?",
    f"{GOOD}defaults: [a]": "2:1 'defaults' must be a mapping | as in {user: robot}",
    f"{GOOD}defaults: {{address: x}}": "2:12 unknown key 'address' of 'defaults' | known: user, "
    "engine, ssh, python, venv, ros, setup, environment, on_link_loss, workspace, node_selector",
    f"{GOOD}place: [x]": "2:1 'place' must be a mapping of patterns to hosts | "
    "as in 'robot_1: bot1'",
    f"{GOOD}place: {{x: bot2}}": "2:12 unknown host 'bot2' | did you mean 'bot1'?",
    f"{GOOD}place: {{x: [bot1, bot2]}}": "2:12 expected the name of one host | "
    "a name of 'hosts', or local",
    f"{GOOD}place:\n  **: bot1": "3:4 invalid YAML: did not find expected alphabetic or numeric "
    "character | what begins with '*' needs quotes: \"**\"",
    f"{GOOD}place:\n  *_1: bot1": '3:3 invalid YAML: found undefined alias | '
    "what begins with '*' needs quotes: \"*_1\"",
    f"{GOOD}discovery: peer": "2:12 'peer' is not one of multicast, peers, server | "
    "did you mean 'peers'?",
    f"{GOOD}discovery: gossip": "2:12 'gossip' is not one of multicast, peers, server",
    f"{GOOD}discovery: {{server: bot1}}": "2:12 'discovery' needs 'mode' | "
    "one of multicast, peers, server",
    f"{GOOD}discovery: {{mode: peers, port: 1}}": "2:26 'port' needs the mode 'server'",
    f"{GOOD}discovery: {{mode: server, server: bot3}}": "2:35 unknown host 'bot3' | "
    "did you mean 'bot1'?",
    f"{GOOD}discovery: {{mode: server, server: bot1, backup: bot1}}": "2:49 'server' and 'backup' "
    "are on the same host, 'bot1', and would fail together | "
    "name another host, or leave 'backup' out",
    f"{GOOD}discovery: {{mode: server, backup: local}}": "2:35 'server' and 'backup' are on the "
    "same host, 'local', and would fail together | name another host, or leave 'backup' out",
    f"{GOOD}discovery: {{mode: server, port: 99999}}": "2:33 this is not a port: "
    "expected 1 to 65535",
}  # fmt: skip


@pytest.mark.parametrize("text", OF_FILE)
def test_mistakes_in_the_file(text: str):
    (found,) = mistakes(text)

    assert found == OF_FILE[text]


@pytest.mark.parametrize(
    ("content", "line", "byte"),
    [(b"hosts:\n  a: b\n# caf\xe9\n", 3, "0xe9"), ("hosts: {}".encode("utf-16"), 1, "0xff")],
)
def test_a_file_that_is_not_utf_8_is_told_with_the_line(
    tmp_path: Path, content: bytes, line: int, byte: str
):
    path = tmp_path / "hosts.yaml"
    path.write_bytes(content)

    with pytest.raises(LauncherError, match=f"the byte {byte} is not UTF-8") as caught:
        hosts_reader.read(str(path))

    assert (caught.value.where, caught.value.exit_code) == (f"{path}:{line}", 2)
    assert caught.value.hint == "save the file as UTF-8"


PATTERNS = {
    "ns/talker": "'ns/talker' is neither a name nor a full name | "
    "names of nodes and namespaces begin with '/': /ns/talker",
    "/ns/": "'/ns/' has an empty name between its slashes | the nodes in a namespace are /ns/**",
    "/": "'/' has an empty name between its slashes | the nodes in a namespace are /**",
    "/a**": "'a**' is not a name with wildcards | '**' stands for whole names: /robot_1/**",
    "pakage:x": "unknown kind of pattern 'pakage:' | did you mean 'package:'?",
    "node:x": "unknown kind of pattern 'node:' | known: process:, package:, include:, group:",
    "'include:'": "'include:' needs a name directly behind it | as in include:robot.launch.py",
    "group:x.py": "'x.py' is neither the namespace nor the place of a group | "
    "as in group:/robot_1 or group:robot.launch.py:42",
    "group:/a/**": "a group is named by its namespace | as in group:/robot_1",
    "''": "expected a pattern of processes | as in robot_1 or /robot_1/**",
    "[a]": "",
}


@pytest.mark.parametrize("pattern", PATTERNS)
def test_mistakes_in_a_pattern(pattern: str):
    (found,) = mistakes(f"{GOOD}place:\n  {pattern}: bot1\n")

    if PATTERNS[pattern]:
        assert found == f"3:3 {PATTERNS[pattern]}"


def test_a_host_with_a_bad_name_hides_no_other_mistake():
    with pytest.raises(LauncherError) as caught:
        hosts_reader.parse(
            "hosts:\n  'bot 1': {addres: 10.0.0.2, engine: docker}\n", "hosts.yaml", {}
        )

    text = caught.value.render()
    assert "'bot 1' is not a name of a host" in text
    assert "docker" in text


def test_a_misspelt_default_is_told_once():
    assert mistakes("defaults: {usr: x}\nhosts: {a: b, c: d}\n") == [
        "1:12 unknown key 'usr' of 'defaults' | did you mean 'user'?"
    ]


# ---- no text makes a traceback

WORDS = """
hosts place defaults discovery address user engine ssh python venv ros setup environment
on_link_loss workspace node_selector from_environment from_file Port IdentityFile bot1 bot2 local
keep systemd peers mode server robot_1 /ns/** package:x group:/a include:a.py ** 10.0.0.2 fd00::1
stop-after=3s ~/x & * ! - {} [] : , # | > ' " null true 1e9 << !!binary &a *a
"""
TOKENS = WORDS.split()
TOKEN = st.sampled_from(
    [*TOKENS, "\n", "\n  ", "\n    ", ": ", "{", "}", "[", "]", " ", "\t", ", "]
)
SCALAR = st.sampled_from(TOKENS) | st.text(max_size=6) | st.integers() | st.none() | st.booleans()
TREE = st.recursive(
    SCALAR,
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(TOKENS) | st.text(max_size=4), inner, max_size=4)
    ),
    max_leaves=12,
)


def refused_or_read(text: str) -> HostsFile | None:
    try:
        return hosts_reader.parse(text, "hosts.yaml", {})
    except LauncherError as error:
        assert error.exit_code == 2
        assert "hosts.yaml" in error.render()
        return None


@given(st.lists(TOKEN, max_size=30).map("".join) | st.text(max_size=60))
@example("[" * 100_000)
@example("- " * 5000)
@example("hosts: &a {b: *a}")
@example("hosts: {a: &x {<<: *x}}")
@example("? [a]\n: b")
@example("hosts: !!python/object:os.system {}")
@example("\0")
@example("\ud800")
@example("hosts: {? {a: b} : c}")
@example("hosts: {a: {address: !!binary YQ==}}")
@example("place: {? !!binary YQ== : a}\nhosts: {a: b}")
def test_any_text_is_read_or_refused(text: str):
    refused_or_read(text)


@given(TREE, TREE, TREE)
def test_any_document_is_read_or_refused(hosts: object, place: object, entry: object):
    import yaml

    document = {"hosts": {"bot1": entry, "bot2": hosts}, "place": place, "discovery": hosts}
    text = yaml.safe_dump(document, allow_unicode=True)
    refused_or_read(text)
    refused_or_read(yaml.safe_dump(hosts))


@given(TREE)
def test_whatever_is_accepted_can_be_used_in_a_command_line(entry: object):
    import yaml

    given = entry if isinstance(entry, dict) else {"user": entry}
    document = {"hosts": {"bot1": {**given, "address": "bot1"}}}
    found = refused_or_read(yaml.safe_dump(document))

    for host in found.hosts.values() if found else ():
        texts = [host.address, host.user or "x", host.python, *host.setup, host.workspace]
        texts += [*host.ssh, *host.ssh.values()]
        assert all((text and text[0] != "-") or text in host.ssh.values() for text in texts)
        assert not any(re.search(r"[\0\n]", text) for text in texts)
