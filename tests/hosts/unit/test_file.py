"""Hosts files: what they say, and every mistake with its place."""

from __future__ import annotations

from textwrap import dedent

import pytest

from launcher.base.errors import LauncherError
from launcher.hosts.file import hosts_reader
from launcher.hosts.file.hosts_model import Host, HostEngine, HostsFile, LinkPolicy, Secret


def read(text: str, environ: dict[str, str] | None = None, **more: bool) -> HostsFile:
    return hosts_reader.parse(dedent(text), "hosts.yaml", environ or {}, **more)


def host(text: str, environ: dict[str, str] | None = None) -> Host:
    (found,) = read(f"hosts:\n  bot1: {text}\n", environ).hosts.values()
    return found


def errors_of(text: str) -> list[str]:
    with pytest.raises(LauncherError) as caught:
        read(text)
    assert caught.value.exit_code == 2
    return caught.value.render().split("\nerror: ")


def test_the_example_of_the_documentation():
    found = read("""\
        hosts:
          bot1: {address: 10.0.0.2, user: robot, engine: ssh, python: .venv/bin/python,
                 ssh: {port: 22, IdentityFile: /k/fleet}}
          bot2: {address: 10.0.0.3, engine: systemd}
        place:
          robot_1: bot1
          /warehouse/**: bot2
    """)

    bot1, bot2 = found.hosts.values()
    assert (bot1.address, bot1.user, bot1.engine) == ("10.0.0.2", "robot", HostEngine.SSH)
    assert (bot1.python, bot1.ssh) == (
        ".venv/bin/python",
        {"Port": "22", "IdentityFile": "/k/fleet"},
    )
    assert (bot2.engine, bot2.user) == (HostEngine.SYSTEMD, None)
    assert [(rule.pattern, rule.host, rule.where) for rule in found.rules] == [
        ("robot_1", "bot1", "hosts.yaml:6"),
        ("/warehouse/**", "bot2", "hosts.yaml:7"),
    ]


def test_an_address_alone_is_a_host():
    assert host("bot1.local").address == "bot1.local"


def test_defaults_are_of_all_hosts_and_mappings_are_merged():
    found = read("""\
        defaults: {user: robot, venv: .venv, ssh: {Port: 2222}, environment: {A: 1, B: 2}}
        hosts:
          bot1: 10.0.0.2
          bot2: {address: 10.0.0.3, user: root, python: /usr/bin/python3, ssh: {Compression: yes},
                 environment: {B: 3}}
    """).hosts

    assert (found["bot1"].user, found["bot1"].python) == ("robot", ".venv/bin/python")
    assert (found["bot2"].user, found["bot2"].python) == ("root", "/usr/bin/python3")
    assert found["bot2"].ssh == {"Port": "2222", "Compression": "yes"}
    assert found["bot2"].environment == {"A": "1", "B": "3"}


def test_values_are_texts_as_they_are_written():
    environment = host(
        "{address: b, environment: {A: yes, B: 0777, C: 1.10, D: 12:30:00}}"
    ).environment

    assert environment == {"A": "yes", "B": "0777", "C": "1.10", "D": "12:30:00"}


def test_setup_files_come_after_the_installation_of_ros():
    found = host("{address: b, ros: /opt/ros/jazzy/, setup: [ws/install/setup.sh, ~/more.sh]}")

    assert found.setup == ("/opt/ros/jazzy/setup.sh", "ws/install/setup.sh", "more.sh")


@pytest.mark.parametrize(
    ("text", "seconds"),
    [("keep", None), ("stop-after=10 s", 10), ("stop-after=1000 ms", 1), ("2 min", 120), ("7", 7)],
)
def test_policies_of_a_lost_link(text: str, seconds: float | None):
    assert host(f"{{address: b, on_link_loss: {text}}}").on_link_loss == LinkPolicy(seconds)


@pytest.mark.parametrize(
    "address", ["10.0.0.2", "fd00::2", "fe80::1%eth0", "robot", "robot-1.fleet.local.", "a_b"]
)
def test_addresses(address: str):
    assert host(f"{{address: '{address}'}}").address == address


def test_a_secret_comes_from_the_environment_of_the_operator():
    text = "{address: b, environment: {TOKEN: {from_environment: FLEET_TOKEN}}}"

    found = host(text, {"FLEET_TOKEN": "s3cret"})

    assert found.environment == {"TOKEN": "s3cret"}
    assert found.secrets == {"TOKEN": Secret(variable="FLEET_TOKEN")}
    assert "s3cret" not in f"{found!r} {found}"


def test_a_plan_needs_no_secrets():
    text = "hosts: {b: {address: b, environment: {T: {from_file: /none}}}}"

    found = read(text, with_secrets=False).hosts["b"]

    assert (found.environment, found.secrets) == ({"T": ""}, {"T": Secret(file="/none")})


def test_a_secret_comes_from_a_file_beside_the_hosts_file(tmp_path):
    (tmp_path / "token").write_text("s3cret\n")
    (tmp_path / "token").chmod(0o640)
    path = tmp_path / "hosts.yaml"
    path.write_text("hosts: {b: {address: b, environment: {T: {from_file: token}}}}")

    found = hosts_reader.read(str(path))

    assert found.hosts["b"].environment == {"T": "s3cret"}
    assert found.warnings == (
        f"{tmp_path}/token can be read by others: chmod 600 {tmp_path}/token",
    )


def test_all_mistakes_are_reported_at_once_in_order_of_their_lines():
    found = errors_of("""\
        hosts:
          bot1: {address: 10.0.0.300, engine: sshd}
        place:
          robot_1: bot2
    """)

    assert found == [
        "error: hosts.yaml:2: '10.0.0.300' is not an IP address: "
        "Octet 300 (> 255) not permitted in '10.0.0.300'\n"
        "      bot1: {address: 10.0.0.300, engine: sshd}\n"
        "                      ^",
        "hosts.yaml:2: 'sshd' is not one of auto, ssh, systemd\n"
        "      bot1: {address: 10.0.0.300, engine: sshd}\n"
        "                                          ^\n"
        "hint: did you mean 'ssh'?",
        "hosts.yaml:4: unknown host 'bot2'\n"
        "      robot_1: bot2\n"
        "               ^\n"
        "hint: did you mean 'bot1'?",
    ]
