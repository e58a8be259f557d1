"""The command lines of OpenSSH."""

from __future__ import annotations

import itertools
import os
import shutil
import socket
import subprocess
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from launcher.base.errors import UsageError
from launcher.hosts.failures import failure
from launcher.hosts.file.hosts_model import Host
from launcher.hosts.ssh import (
    MADE_WITH,
    SYNCED_PYTHON,
    SshConnection,
    new_control_path,
    posix_shell,
    python_script,
    setup_script,
    ssh_environment,
)

TEXT = st.text(st.characters(blacklist_categories=["Cs"], blacklist_characters="\0"), max_size=20)


def host(**fields: object) -> Host:
    return Host(**{"name": "bot1", "address": "10.0.0.2", **fields})  # type: ignore[arg-type]


def options(words: list[str]) -> list[str]:
    return [word for before, word in itertools.pairwise(words) if before == "-o"]


def first_values(words: list[str]) -> dict[str, str]:
    """What ssh uses: of two values for an option, the first."""
    values: dict[str, str] = {}
    for option in options(words):
        name, _, value = option.partition("=")
        values.setdefault(name, value)
    return values


def test_a_session_never_asks_and_checks_the_host_key():
    values = first_values(SshConnection(host(), "/run/x").session("true"))

    assert values["BatchMode"] == "yes"
    assert values["StrictHostKeyChecking"] == "yes"
    assert int(values["ServerAliveInterval"]) * int(values["ServerAliveCountMax"]) > 16


def test_options_of_the_hosts_file_come_before_the_defaults():
    own = {"StrictHostKeyChecking": "accept-new", "BatchMode": "no", "Port": "2222"}

    values = first_values(SshConnection(host(ssh=own), "/run/x").session("true"))

    assert values["StrictHostKeyChecking"] == "accept-new"
    assert values["Port"] == "2222"
    assert values["BatchMode"] == "yes"


def test_a_master_of_the_user_is_used_but_never_one_that_may_be_lost():
    connection = SshConnection(host(), None)

    assert "ControlPath" not in first_values(connection.session("true"))
    assert first_values(connection.session("true"))["ControlMaster"] == "no"
    assert first_values(connection.alone("true"))["ControlPath"] == "none"


@pytest.mark.parametrize("address", ["-oProxyCommand=touch /tmp/x", "10.0.0.2"])
def test_an_address_is_no_option(address: str):
    words = SshConnection(host(address=address), None).session("true")

    assert words[words.index("--") + 1] == address


def test_each_socket_has_a_path_of_its_own_in_a_private_folder():
    paths = {new_control_path(os.environ) for _ in range(3)}

    assert len(paths) == 3
    assert {os.stat(os.path.dirname(path)).st_mode & 0o777 for path in paths} == {0o700}


def test_a_path_that_is_too_long_for_a_socket_is_not_taken(tmp_path: Path):
    longer = tmp_path / ("x" * 80)
    longer.mkdir()

    assert new_control_path({"TMPDIR": str(longer)}).startswith("/tmp/ros-launcher-")


@pytest.mark.skipif(shutil.which("ssh") is None, reason="needs ssh")
@pytest.mark.parametrize("folder", ["/run/a b", '/run/it\'s "x"', "/run/%h\\\\$x", "/run/#1,=~"])
def test_a_socket_may_be_in_any_folder(folder: str):
    words = SshConnection(host(), f"{folder}/1.ssh").session("true")
    place = words.index("--")

    found = subprocess.run([*words[:place], "-G", *words[place:]], capture_output=True, check=False)
    assert found.stderr == b""
    assert f"controlpath {folder}/1.ssh" in found.stdout.decode().splitlines()


def test_the_socket_of_a_killed_ssh_is_removed():
    killed, used = (Path(new_control_path(os.environ)) for _ in range(2))
    with socket.socket(socket.AF_UNIX) as first, socket.socket(socket.AF_UNIX) as second:
        first.bind(str(killed))
        first.close()
        second.bind(str(used))
        second.listen()

        new_control_path(os.environ)
        assert not killed.exists()
        assert used.exists()
    used.unlink()


@pytest.mark.parametrize("ssh", [{"Port": "22\nProxyCommand=x"}, {"Port Proxy": "1"}])
def test_an_option_of_two_lines_or_words_is_refused(ssh: dict[str, str]):
    with pytest.raises(UsageError, match="cannot be given to ssh"):
        SshConnection(host(ssh=ssh), None)


def test_messages_of_ssh_are_english_and_the_encoding_stays():
    env = ssh_environment({"LC_ALL": "de_DE.UTF-8", "LANGUAGE": "de", "A": "b"})

    assert env == {"LANG": "de_DE.UTF-8", "LC_MESSAGES": "C", "A": "b"}


@given(words=st.lists(TEXT, min_size=1, max_size=4))
def test_words_reach_the_program_unchanged(words: list[str]):
    script = python_script(host(python="printf"), ["%s\\0", *words])

    found = subprocess.run(["sh", "-c", posix_shell(script)], capture_output=True, check=True)

    assert found.stdout == b"".join(word.encode() + b"\0" for word in words)


@given(name=TEXT.filter(lambda text: text.strip("/.~") and "/" not in text))
def test_the_name_of_a_setup_file_is_no_command(name: str):
    script = posix_shell(setup_script(host(setup=(name,))) + "echo reached")

    result = subprocess.run(
        ["sh", "-c", script],
        capture_output=True,
        check=False,
        stdin=subprocess.DEVNULL,
        env={"HOME": "/sys/kernel/mm"},
    )

    assert result.stdout == b""


def test_setup_files_are_read_in_the_home_and_do_not_print_to_the_protocol(tmp_path: Path):
    (tmp_path / "my setup.sh").write_text("echo noise; A=found; false\n")
    words = posix_shell(setup_script(host(setup=("~/my setup.sh",))) + 'echo "$A"')

    for shell in {shutil.which(name) for name in ("sh", "bash", "zsh", "fish")} - {None}:
        result = subprocess.run(
            [str(shell), "-c", words],
            capture_output=True,
            check=True,
            env={"HOME": str(tmp_path), "PATH": "/usr/bin:/bin"},
        )
        assert (result.stdout, result.stderr) == (b"found\n", b"noise\n")


def python_used(home: Path, one: Host) -> bytes:
    words = posix_shell(python_script(one, ["-m", "launcher"]))
    env = env_of(home)
    return subprocess.run(["sh", "-c", words], capture_output=True, check=False, env=env).stdout


def env_of(home: Path) -> dict[str, str]:
    return {"HOME": str(home), "PATH": "/usr/bin:/bin"}


NAMED = "./my '$(touch injected) venv/bin/python"


def program(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\necho {text}\n")
    path.chmod(0o755)
    return path


def test_the_python_that_was_synchronized_is_used_if_there_is_one(tmp_path: Path):
    folder = "my workspace/'$(touch injected)"
    one = host(workspace=f"~/{folder}/")
    program(tmp_path / folder / SYNCED_PYTHON, "brought")

    assert python_used(tmp_path, one) == b"brought\n"
    assert not (tmp_path / "injected").exists()


@pytest.mark.parametrize(
    ("made_with", "used"),
    [
        (None, b"own\n"),
        ("python3", b"own\n"),
        (f"python3\n{NAMED}", b"own\n"),
        (NAMED, b"brought\n"),
        (f"{NAMED}\n{NAMED}", b"brought\n"),
    ],
)
def test_the_python_of_the_hosts_file_wins_unless_it_was_synchronized(
    tmp_path: Path, made_with: str | None, used: bytes
):
    one = host(python=NAMED.removeprefix("./"), workspace="ws")
    brought = program(tmp_path / "ws" / SYNCED_PYTHON, "brought")
    if made_with is not None:
        brought.with_name(MADE_WITH).write_text(f"{made_with}\n")

    before = python_used(tmp_path, one)
    program(tmp_path / one.python, "own")

    assert (before, python_used(tmp_path, one)) == (b"brought\n", used)
    assert not (tmp_path / "injected").exists()


@pytest.mark.parametrize("named", ["python3", "./.venv/bin/python"])
def test_a_python_that_was_named_after_the_last_sync_has_to_be_there(tmp_path: Path, named: str):
    one = host(python="/opt/not/there/bin/python", workspace="ws")
    brought = program(tmp_path / "ws" / SYNCED_PYTHON, "brought")
    brought.with_name(MADE_WITH).write_text(f"python3\n{named}\n")
    words = posix_shell(python_script(one, ["-m", "launcher"]))

    env = env_of(tmp_path)
    done = subprocess.run(["sh", "-c", words], capture_output=True, check=False, env=env)

    error = failure(one, done.stderr.decode(), done.returncode)
    assert done.stdout == b""
    assert "there is no Python '/opt/not/there/bin/python'" in error.message
