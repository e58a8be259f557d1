"""The command that installs what building needs."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from launcher.base.errors import LauncherError
from launcher.packages import extras
from launcher.workspace.building import extra

install_command = extras.install_command.__wrapped__

PIP = f"{sys.executable} -m pip install"


def test_nothing_is_missing_here():
    assert extra.missing() == []
    extra.require()


@pytest.mark.parametrize(
    ("origin", "words"),
    [
        ({"url": "file:///a%20b", "dir_info": {"editable": True}}, "--editable '/a b[build]'"),
        ({"url": "file:///home/me/it", "dir_info": {}}, "'/home/me/it[build]'"),
        (
            {"url": "https://x.org/r.git", "vcs_info": {"vcs": "git", "commit_id": "12ab"}},
            "'ros2-launcher[build] @ git+https://x.org/r.git@12ab'",
        ),
        (
            {
                "url": "ssh://git@x.org/r.git",
                "vcs_info": {"vcs": "git", "commit_id": "12ab"},
                "subdirectory": "launcher",
            },
            "'ros2-launcher[build] @ git+ssh://git@x.org/r.git@12ab#subdirectory=launcher'",
        ),
        (
            {"url": "https://x.org/r.zip", "archive_info": {}},
            "'ros2-launcher[build] @ https://x.org/r.zip'",
        ),
    ],
)
def test_the_command_fits_the_installation(
    monkeypatch: pytest.MonkeyPatch, origin: dict[str, object], words: str
):
    monkeypatch.setattr(extras, "_direct_url", lambda: origin)

    assert install_command("build") == f"{PIP} {words}"


def test_the_checkout_is_named_where_nothing_is_installed(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
):
    checkout = tmp_path / "50%25 #1"
    checkout.mkdir()
    (checkout / "pyproject.toml").touch()
    monkeypatch.setattr(extras, "DISTRIBUTION", "no-such-distribution")
    monkeypatch.setattr(extras, "_FOLDER", str(checkout))

    assert install_command("build") == f"{PIP} --editable '{checkout}[build]'"


def test_what_is_missing_is_named_with_the_command(monkeypatch: pytest.MonkeyPatch):
    wanted = ["colcon-none; extra == 'build'", "cmake<1; extra == 'build'", "psutil"]
    monkeypatch.setattr(extra.metadata, "requires", lambda _: wanted)

    with pytest.raises(LauncherError) as raised:
        extra.require()

    assert raised.value.message.startswith(
        "building needs packages that are not installed: colcon-none, cmake<1 (there is 3."
    )
    assert raised.value.hint == f"install them once: {install_command(','.join(extra.extras()))}"
