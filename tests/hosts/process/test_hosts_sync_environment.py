"""The environments of Python that `hosts sync` makes, on hosts that are homes of this machine."""

from __future__ import annotations

import contextlib
import http.server
import os
import socket
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from launcher.base.errors import UsageError
from launcher.hosts import verbs as hosts
from launcher.hosts.sync import wheels
from launcher.hosts.verbs.sync_report import SyncReport
from tests.support.sync_hosts import PLAIN_PYTHON, Site, brought, fails, pinned, tiny_wheel


@pytest.fixture
def site_with_venv(tmp_path: Path) -> Site:
    return Site(tmp_path / "bot", python=PLAIN_PYTHON)


@pytest.mark.thorough
def test_an_environment_is_made_from_wheels_and_shared_by_releases(site_with_venv: Site, tmp_path):
    site, house = site_with_venv, tmp_path / "house"
    tiny_wheel(house, "tiny", "1.0")
    options = {"requirements": pinned("tiny==1.0"), "wheelhouse": str(house)}

    first = site.sync(brought(a="1"), **options)
    second = site.sync(brought(a="2"), **options)

    assert first.environment_s is not None and second.environment_s is None
    assert site.run("-c", "import tiny; print(tiny.VERSION)") == "1.0\n"
    assert len(list((site.workspace / "venvs").iterdir())) == 1
    assert not site.sync(brought(a="2"), **options).is_changed


@pytest.mark.thorough
def test_another_list_makes_another_environment_and_rollback_has_the_old_one(
    site_with_venv: Site, tmp_path: Path
):
    site, house = site_with_venv, tmp_path / "house"
    for version in ("1.0", "2.0"):
        tiny_wheel(house, "tiny", version)
        listed = pinned("# a comment", f"tiny=={version}")
        site.sync(brought(a="1"), requirements=listed, wheelhouse=str(house))
    assert site.run("-c", "import tiny; print(tiny.VERSION)") == "2.0\n"

    site.roll_back()

    assert site.run("-c", "import tiny; print(tiny.VERSION)") == "1.0\n"


@pytest.mark.thorough
def test_an_unfinished_environment_is_made_again(site_with_venv: Site, tmp_path: Path):
    site, house = site_with_venv, tmp_path / "house"
    tiny_wheel(house, "tiny", "1.0")
    options = {"requirements": pinned("tiny==1.0"), "wheelhouse": str(house)}
    site.sync(brought(a="1"), **options)
    (venv,) = (site.workspace / "venvs").iterdir()
    (venv / "launcher-complete").unlink()
    (venv / "bin/python").unlink()

    done = site.sync(brought(a="1"), **options)

    assert done.environment_s is not None
    assert site.run("-c", "import tiny; print(tiny.VERSION)") == "1.0\n"


def test_a_wheelhouse_that_is_a_file_is_refused(tmp_path: Path):
    file = tmp_path / "wheels.zip"
    file.touch()
    hosts_file = tmp_path / "hosts.yaml"
    hosts_file.write_text("hosts: {bot: 10.0.0.2}\n")

    with pytest.raises(UsageError, match=r"--wheelhouse: .*wheels\.zip is not a folder") as caught:
        hosts.main(["sync", f"--hosts={hosts_file}", f"--wheelhouse={file}"])
    with pytest.raises(UsageError, match="--rollback and --wheelhouse"):
        hosts.main(["sync", f"--hosts={hosts_file}", "--rollback", f"--wheelhouse={tmp_path}"])

    assert caught.value.hint == "name the folder of the wheels, or a new one: it is filled"


@pytest.mark.thorough
def test_a_missing_wheel_is_told_before_anything_is_sent(site_with_venv: Site, tmp_path: Path):
    house = tmp_path / "house"
    tiny_wheel(house, "tiny_of_nobody", "1.0", "cp38-cp38-manylinux_2_99_riscv64")
    options = {"requirements": pinned("tiny-of-nobody==1.0"), "wheelhouse": str(house)}

    error = fails(site_with_venv, brought(a="1"), **options)

    assert "has no wheel of tiny_of_nobody==1.0 for Python 3." in error.message
    assert "there is only tiny_of_nobody-1.0-cp38-cp38-manylinux_2_99_riscv64.whl" in error.message
    assert list(site_with_venv.home.iterdir()) == []


@pytest.fixture
def only_index(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Makes an address the only place from which pip takes packages."""
    for name in [name for name in os.environ if name.startswith("PIP_")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("PIP_CONFIG_FILE", os.devnull)
    monkeypatch.setenv("NO_PROXY", "*")
    monkeypatch.setattr(wheels, "_is_offline", False)
    return lambda address: monkeypatch.setenv("PIP_INDEX_URL", f"{address}/simple")


def test_an_operator_without_a_network_is_told_what_to_do(
    site_with_venv: Site, tmp_path: Path, only_index: Callable[[str], None]
):
    house = tmp_path / "house"
    options = {"requirements": pinned("tiny==1.0"), "wheelhouse": str(house)}
    only_index("http://127.0.0.1:9")  # nobody listens there

    error = fails(site_with_venv, brought(a="1"), **options)

    assert "lacks tiny==1.0, and pip reaches no index of packages from here" in error.message
    assert (error.hint or "").startswith("repeat it with a network; or run it on a machine that")
    assert list(site_with_venv.home.iterdir()) == []


@pytest.mark.thorough
def test_an_index_with_which_no_connection_is_made_is_not_told_as_a_missing_package(
    site_with_venv: Site, tmp_path: Path, only_index: Callable[[str], None]
):
    options = {"requirements": pinned("tiny==1.0"), "wheelhouse": str(tmp_path / "house")}
    with socket.create_server(("127.0.0.1", 0)) as server:
        threading.Thread(target=_answer_without_tls, args=(server,), daemon=True).start()
        only_index(f"https://127.0.0.1:{server.getsockname()[1]}")
        error = fails(site_with_venv, brought(a="1"), **options)

    assert (error.hint or "").startswith("pip download failed: SSLError(")


def _answer_without_tls(server: socket.socket) -> None:
    with contextlib.suppress(OSError):  # the test has closed it
        while True:
            connection, _ = server.accept()
            with connection, contextlib.suppress(OSError):
                connection.recv(1000)
                connection.sendall(b"this is not TLS\n")


@pytest.mark.thorough
def test_a_try_that_was_repeated_is_not_told_as_the_reason_of_a_missing_package(
    site_with_venv: Site, tmp_path: Path, only_index: Callable[[str], None]
):
    """Pip warns of the connection that breaks, and gets the page of `tiny` from the next one."""
    wheel = tiny_wheel(tmp_path / "index", "tiny", "1.0")
    pins = pinned("tiny==1.0", "tiny-of-nobody==1.0")
    asked: list[str] = []

    class Index(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            asked.append(self.path)
            if len(asked) == 1:
                self.close_connection = True
                return
            page = f'<!DOCTYPE html><a href="/{wheel.name}">{wheel.name}</a>'.encode()
            found = {"/simple/tiny/": page, f"/{wheel.name}": wheel.read_bytes()}
            content = found.get(self.path, b"")
            self.send_response(200 if content else 404)
            self.send_header("Content-Type", "text/html")
            self.send_header("Content-Length", str(len(content)))
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, format: str, *args: object) -> None:
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Index) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        only_index(f"http://127.0.0.1:{server.server_port}")
        options = {"requirements": pins, "wheelhouse": str(tmp_path / "house")}
        error = fails(site_with_venv, brought(a="1"), **options)
        server.shutdown()

    assert asked[:2] == ["/simple/tiny/"] * 2
    missing = "No matching distribution found for tiny-of-nobody==1.0"
    assert (error.hint or "").startswith(f"pip download failed: {missing}")


def dry_run(site: Site, capsys, **options: object) -> list[str]:
    """What a dry run prints; it writes nothing."""
    before = sorted(site.home.parent.rglob("*"))
    done = site.sync(brought(a="1"), dry_run=True, **options)
    assert sorted(site.home.parent.rglob("*")) == before
    SyncReport([site.host], dry_run=True).add(site.host, done)
    return capsys.readouterr().out.splitlines()


@pytest.mark.thorough
def test_a_dry_run_tells_of_the_environment_and_downloads_nothing(
    site_with_venv: Site, tmp_path: Path, capsys
):
    site, house = site_with_venv, tmp_path / "house"
    listed = {"requirements": pinned("tiny==1.0", "tiny-of-nobody==1.0")}
    in_house = {**listed, "wheelhouse": str(house)}

    by_pip = dry_run(site, capsys, **listed)
    from_nothing = dry_run(site, capsys, **in_house)
    tiny_wheel(house, "tiny", "1.0")
    half = dry_run(site, capsys, **in_house)
    size = tiny_wheel(house, "tiny_of_nobody", "1.0").stat().st_size
    whole = dry_run(site, capsys, **in_house)

    assert by_pip[0].startswith("bot: would send 3 files, ")
    assert by_pip[1] == "  environment: would be made by pip there"
    made = "  environment: would be made of 2 wheels, 2 of them sent"
    assert from_nothing[1].startswith(f"{made}, after the download of tiny==1.0, tiny_of_nobody==")
    assert half[1] == f"{made}, after the download of tiny_of_nobody==1.0 into {house}"
    both = size + (house / "tiny-1.0-py3-none-any.whl").stat().st_size
    assert whole[1] == f"{made}, {both / 1e3:.1f} kB"

    site.sync(brought(a="0"), **in_house)
    assert [line.strip() for line in dry_run(site, capsys, **in_house)[1:]] == ["~ a"]
    forced = dry_run(site, capsys, **in_house, force=True)
    assert forced[0].startswith("bot: would send 3 files, ")
    assert forced[1].startswith("  environment: would be made of 2 wheels, 0 of them sent")


@pytest.mark.thorough
def test_wheels_are_not_needed_where_the_environment_is_there(site_with_venv: Site, tmp_path: Path):
    site, house = site_with_venv, tmp_path / "house"
    wheel = tiny_wheel(house, "tiny_of_nobody", "1.0")
    options = {"requirements": pinned("tiny-of-nobody==1.0"), "wheelhouse": str(house)}
    site.sync(brought(a="1"), **options)
    wheel.unlink()

    assert site.sync(brought(a="2"), **options).is_changed
    assert list(house.iterdir()) == []


@pytest.mark.thorough
def test_a_broken_wheel_leaves_the_old_release(site_with_venv: Site, tmp_path: Path):
    site, house = site_with_venv, tmp_path / "house"
    site.sync(brought(a="1"))
    old = site.release
    tiny_wheel(house, "tiny", "1.0").write_bytes(b"not a zip")

    error = fails(site, brought(a="2"), requirements=pinned("tiny==1.0"), wheelhouse=str(house))

    assert "pip failed" in error.message
    assert site.release == old
    assert list((site.workspace / "venvs").iterdir()) == []


def test_a_host_with_an_installation_of_ros_gets_no_environment(tmp_path: Path):
    site = Site(tmp_path / "bot", python="python3", setup=("setup of ros.sh",))
    (site.home / "setup of ros.sh").touch()

    house = tmp_path / "house"
    site.sync(brought(a="1"), requirements=pinned("tiny==1.0"), wheelhouse=str(house))

    unused = "it has `setup`, so no environment is made, and --wheelhouse is not used"
    assert (site.messages, house.exists()) == ([unused], False)
    assert "exec python3 " in (site.current / "bin/python").read_text()
    assert list((site.workspace / "venvs").iterdir()) == []
