"""The cipher that ssh is to prefer."""

from __future__ import annotations

import pwd
from pathlib import Path

import pytest

from launcher.hosts import ciphers
from launcher.hosts.file.hosts_model import Host
from launcher.hosts.ssh import SshConnection


@pytest.mark.parametrize(
    "text",
    [
        "Ciphers aes256-ctr\n",
        "Host bot*\n\tciphers=aes256-ctr\n",
        "# for the shop floor\ninclude parts/*.conf",
        "Include missing {folder}/parts/one.conf\n",
        "Include ~/parts/one.conf\n",
        "Include parts/%h.conf\n",
    ],
)
def test_a_cipher_of_the_configuration_of_ssh_is_found(
    text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    user = pwd.struct_passwd(("me", "x", 1, 1, "", str(tmp_path), "/bin/sh"))
    monkeypatch.setattr(pwd, "getpwuid", lambda uid: user)
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts/one.conf").write_text("Host *\n  Ciphers aes256-ctr\n")
    (tmp_path / "config").write_text(text.format(folder=tmp_path))

    assert ciphers.names_ciphers(str(tmp_path / "config"), str(tmp_path))


@pytest.mark.parametrize("text", ["", "# Ciphers aes256-ctr\nPort 22\n", "Include config\n"])
def test_without_one_none_is_found(text: str, tmp_path: Path):
    (tmp_path / "config").write_text(text)

    assert not ciphers.names_ciphers(str(tmp_path / "config"), str(tmp_path))
    assert not ciphers.names_ciphers(str(tmp_path / "missing"), str(tmp_path))


OLD = "echo \"command-line line 0: Bad SSH2 cipher spec '$7'.\" >&2; exit 255"
NEW = "echo host x; echo ciphers aes128-gcm@openssh.com,aes128-ctr"


@pytest.mark.parametrize(
    ("ssh", "expected"), [(None, None), (OLD, None), ("exit 0", None), (NEW, ciphers.PREFERRED)]
)
def test_it_is_preferred_only_by_an_ssh_that_accepts_it(
    ssh: str | None, expected: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    if ssh is not None:
        (tmp_path / "ssh").write_text(f"#!/bin/sh\n{ssh}\n")
        (tmp_path / "ssh").chmod(0o700)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(ciphers, "_has_aes", lambda: True)
    monkeypatch.setattr(ciphers, "_is_chosen", lambda: False)

    assert ciphers.preferred.__wrapped__() == expected


def test_nothing_is_preferred_for_a_user_without_an_entry(monkeypatch: pytest.MonkeyPatch):
    def missing(uid: int) -> pwd.struct_passwd:
        raise KeyError(uid)

    monkeypatch.setattr(pwd, "getpwuid", missing)
    monkeypatch.setattr(ciphers, "_has_aes", lambda: True)

    assert ciphers.preferred.__wrapped__() is None


def test_a_cipher_of_the_hosts_file_comes_before_the_preferred_one(
    monkeypatch: pytest.MonkeyPatch,
):
    monkeypatch.setattr(ciphers, "preferred", lambda: ciphers.PREFERRED)
    own = Host(name="bot1", address="10.0.0.2", ssh={"Ciphers": "aes256-ctr"})

    words = SshConnection(own, None).session("true")

    found = [word for word in words if word.startswith("Ciphers=")]
    assert found == ["Ciphers=aes256-ctr", f"Ciphers={ciphers.PREFERRED}"]  # ssh takes the first
