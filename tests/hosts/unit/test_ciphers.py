"""The cipher that ssh is to prefer."""

from __future__ import annotations

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
    ],
)
def test_a_cipher_of_the_configuration_of_ssh_is_found(text: str, tmp_path: Path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts/one.conf").write_text("Host *\n  Ciphers aes256-ctr\n")
    (tmp_path / "config").write_text(text.format(folder=tmp_path))

    assert ciphers.names_ciphers(str(tmp_path / "config"), str(tmp_path))


@pytest.mark.parametrize("text", ["", "# Ciphers aes256-ctr\nPort 22\n", "Include config\n"])
def test_without_one_none_is_found(text: str, tmp_path: Path):
    (tmp_path / "config").write_text(text)

    assert not ciphers.names_ciphers(str(tmp_path / "config"), str(tmp_path))
    assert not ciphers.names_ciphers(str(tmp_path / "missing"), str(tmp_path))


def test_a_cipher_of_the_hosts_file_comes_before_the_preferred_one(
    monkeypatch: pytest.MonkeyPatch,
):
    monkeypatch.setattr(ciphers, "preferred", lambda: ciphers.PREFERRED)
    own = Host(name="bot1", address="10.0.0.2", ssh={"Ciphers": "aes256-ctr"})

    words = SshConnection(own, None).session("true")

    found = [word for word in words if word.startswith("Ciphers=")]
    assert found == ["Ciphers=aes256-ctr", f"Ciphers={ciphers.PREFERRED}"]  # ssh takes the first
