"""Who may see the page and steer the run: token, cookie, Host, Origin, read-only."""

from __future__ import annotations

import json
import os
import re
import socket
import stat
import subprocess
from pathlib import Path
from urllib.parse import urlsplit

import psutil
import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from tests.support.waiting import wait_until
from tests.support.web_page import PageClient, cookie_of, get
from tests.web.process.conftest import Start

FORBIDDEN = 403


@pytest.mark.thorough
def test_only_who_has_the_token_sees_anything(start: Start, sleeper: Path):
    _, link = start(sleeper)
    token = link.partition("token=")[2]
    cookie = cookie_of(link)

    for path in ("/", "/?token=", f"/?token={token[:-1]}", "/page/main.js", "/lib/vue.js"):
        status, _, text = get(link, path)
        assert (status, "token" in text) == (FORBIDDEN, True), path
        assert token not in text
    name, _, value = cookie.partition("=")
    assert token not in cookie
    wrong = f"{name}={'0' * len(value)}"
    assert get(link, "/page/main.js", Cookie=wrong)[0] == FORBIDDEN
    assert get(link, "/page/main.js", Cookie=cookie)[0] == 200
    assert get(link, "/", Cookie=cookie)[0] == 200


@pytest.mark.thorough
def test_the_cookie_is_for_this_site_and_not_for_scripts(start: Start, sleeper: Path):
    _, link = start(sleeper)

    _, headers, text = get(link)

    assert "httponly" in headers["set-cookie"].lower()
    assert "samesite=strict" in headers["set-cookie"].lower()
    policy = headers["content-security-policy"]
    assert "default-src 'none'" in policy and "frame-ancestors 'none'" in policy
    assert "script-src 'self' 'unsafe-eval' 'sha256-" in policy
    assert "unsafe-inline" not in policy.partition("script-src")[2].partition(";")[0]
    assert headers["referrer-policy"] == "no-referrer"
    # Nothing is fetched from elsewhere.
    assert not re.findall(r"""(?:src|href)=["'](?:https?:)?//""", text)


@pytest.mark.thorough
@pytest.mark.parametrize(
    "host",
    ["evil.example", "evil.example:8770", "127.0.0.1.evil.example", "", "[::1", "localhost."],
)
def test_a_name_that_was_pointed_here_is_refused(start: Start, sleeper: Path, host: str):
    _, link = start(sleeper)
    cookie = cookie_of(link)

    for path in ("/page/main.js", f"/?{urlsplit(link).query}"):
        status, headers, _ = get(link, path, Host=host, Cookie=cookie)
        assert status in (400, FORBIDDEN)
        assert "set-cookie" not in headers
    port = urlsplit(link).port
    for name in (f"localhost:{port}", "127.0.0.1:9000", "[::1]:9000"):
        assert get(link, "/page/main.js", Host=name, Cookie=cookie)[0] == 200


@pytest.mark.thorough
def test_a_websocket_of_another_site_is_refused(start: Start, sleeper: Path):
    _, link = start(sleeper)
    parts = urlsplit(link)
    cookie = cookie_of(link)
    url = f"ws://{parts.netloc}/feed"

    for origin, fields in [
        ("http://evil.example", {"Cookie": cookie}),
        ("http://127.0.0.1:1", {"Cookie": cookie}),  # another server on this machine
        ("null", {"Cookie": cookie}),
        (None, {"Cookie": cookie}),
        (f"http://{parts.netloc}", {}),
        (f"https://{parts.netloc}", {"Cookie": cookie}),
    ]:
        with (
            pytest.raises(InvalidStatus) as refused,
            connect(url, origin=origin, additional_headers=fields),
        ):
            pass
        assert refused.value.response.status_code == FORBIDDEN, origin
    with PageClient(link) as page:
        assert page.open()["read_only"] is False


@pytest.mark.thorough
def test_the_cookie_alone_opens_no_feed(start: Start, sleeper: Path):
    """A browser sends it to every port of this host: another server may have it."""
    run, link = start(sleeper)
    assert 'content=""' in get(link, "/", Cookie=cookie_of(link))[2]

    for key in (None, "", 7, "0" * 64):
        with PageClient(link) as page:
            answer = page.ask("run", verb="stop", names=["cat"])
            assert answer["error"]["code"] == "no-key"
            page.socket.send(json.dumps({"id": 9, "do": "open", "key": key}))
            wait_until(lambda page=page: page.socket.close_code == 4403, "the end")
            assert page.events == []
    assert run.row("cat")["state"] == "RUNNING"


@pytest.mark.thorough
def test_the_page_does_what_the_socket_does_and_no_more(start: Start, sleeper: Path):
    run, link = start(sleeper)
    with PageClient(link) as page:
        hello = page.open()
        assert hello["run"]["pid"] == run.process.pid

        answer = page.ask("run", verb="send", names=["cat"], options={"text": "<b>hello</b>"})
        assert answer["ok"], answer
        run.wait_for_log("cat-1", "<b>hello</b>")
        for verb, code in [("reboot", "unknown-verb"), ("pick", "bad-request")]:
            assert page.ask("run", verb=verb, names=[])["error"]["code"] == code
        for bad in (
            {"do": "probe", "request": {"do": "draw", "json": "/tmp/x", "svg": "/tmp/y"}},
            {"do": "probe", "request": {"do": "subscribe"}},
            {"do": "probe", "request": []},
            {"do": "older", "before": "x", "count": 1},
            {"do": "run", "verb": "logs", "options": {"follow": True}},
            {"do": "plot", "topic": 1},
            {"do": "nothing"},
            {"do": None},
        ):
            answer = page.ask(**bad)
            assert not answer["ok"] and answer["error"]["code"] == "bad-request", (bad, answer)
        page.socket.send("[1, 2")
        page.socket.send("7")
        page.socket.send(b"\x00\xff")
        assert page.ask("older", before=10, count=5)["ok"]


@pytest.mark.thorough
def test_a_page_that_only_shows_changes_nothing(start: Start, sleeper: Path):
    run, link = start(sleeper, "--web-read-only")
    with PageClient(link) as page:
        assert page.open()["read_only"] is True

        for verb in ("stop", "kill", "start", "restart", "mute", "send", "quit", "level", "reload"):
            answer = page.ask("run", verb=verb, names=["cat"], options={})
            assert answer["error"]["code"] == "read-only", verb
        for what in ("set_parameters", "call", "publish"):
            answer = page.ask("probe", request={"do": what})
            assert answer["error"]["code"] == "read-only", what
        assert page.ask("run", verb="info", names=["cat"])["ok"]
    assert run.row("cat")["state"] == "RUNNING"


def test_the_token_is_in_no_file_and_no_command_line(start: Start, sleeper: Path, tmp_path: Path):
    run, link = start(sleeper)
    token = link.partition("token=")[2]
    with run.connect() as connection:
        folder = Path(connection.hello["run"]["log_dir"])

    assert folder.is_dir()
    below = [Path(where, name) for where, _, names in os.walk(folder) for name in names]
    for process in psutil.process_iter(["cmdline"]):
        assert token not in " ".join(process.info["cmdline"] or ()), process
    for file in below:
        try:
            assert token.encode() not in file.read_bytes(), file
        except OSError:
            continue  # it was renamed


@pytest.mark.thorough
def test_a_token_of_a_file_is_used(start: Start, sleeper: Path, tmp_path: Path):
    file = tmp_path / "token"
    file.write_text("correct horse&battery#+%41\n")
    file.chmod(0o600)

    _, link = start(sleeper, "--web-token", str(file))

    assert link.endswith("/?token=correct%20horse%26battery%23%2B%2541")
    assert get(link)[0] == 200


@pytest.mark.parametrize(
    ("text", "mode", "problem"),
    [
        ("correct-horse-battery", 0o644, "other users may read"),
        ("short", 0o600, "at least 16"),
        ("two lines of\ntext that is long enough", 0o600, "one line"),
        (None, 0, "cannot read the token"),
    ],
)
def test_a_token_that_is_no_secret_is_refused(
    command, tmp_path: Path, text: str | None, mode: int, problem: str
):
    file = tmp_path / "token"
    if text is not None:
        file.write_text(text)
        file.chmod(mode)

    answer = command("system", "--web", "--web-token", str(file))

    assert answer.returncode == 2
    assert problem in answer.stderr


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (["--web-port", "1"], "need --web"),
        (["--web-read-only"], "need --web"),
        (["--web", "--no-control"], "excludes --no-control"),
        (["--web", "--web-port", "70000"], "--web-port"),
        (["--web", "--web-tls", "one"], "is not CERT,KEY"),
        (["--web", "--web-tls", "/no/cert,/no/key"], "cannot read '/no/cert'"),
    ],
)
def test_options_that_make_no_sense_are_refused(command, words: list[str], problem: str):
    answer = command("system", *words)

    assert answer.returncode == 2
    assert problem in answer.stderr


@pytest.mark.thorough
def test_who_listens_elsewhere_is_told_what_that_risks(start: Start, sleeper: Path):
    run, link = start(sleeper, "--web-host", "0.0.0.0")

    run.wait_for("without encryption")
    parts = urlsplit(link)
    assert get(parts._replace(netloc=f"127.0.0.1:{parts.port}").geturl())[0] == 200


@pytest.mark.thorough
def test_a_page_can_be_encrypted(start: Start, sleeper: Path, tmp_path: Path):
    certificate, key = tmp_path / "cert.pem", tmp_path / "key.pem"
    words = [
        "req",
        "-x509",
        "-newkey",
        "rsa:2048",
        "-nodes",
        "-days",
        "2",
        "-subj",
        "/CN=localhost",
    ]
    subprocess.run(
        ["openssl", *words, "-out", str(certificate), "-keyout", str(key)],
        check=True,
        capture_output=True,
    )
    assert stat.S_IMODE(os.stat(key).st_mode) == 0o600

    run, link = start(sleeper, "--web-host", "0.0.0.0", "--web-tls", f"{certificate},{key}")

    assert link.startswith("https://")
    assert "without encryption" not in run.screen
    answer = subprocess.run(
        [
            "curl",
            "-s",
            "-i",
            "--cacert",
            str(certificate),
            f"https://localhost:{urlsplit(link).port}/?{urlsplit(link).query}",
        ],
        capture_output=True,
        text=True,
        check=True,
    )
    assert "200" in answer.stdout.splitlines()[0]
    assert "; Secure" in answer.stdout


@pytest.mark.thorough
def test_a_connection_without_a_request_is_closed(start: Start, sleeper: Path):
    _, link = start(sleeper)
    parts = urlsplit(link)
    with (
        PageClient(link) as page,
        socket.create_connection((parts.hostname, parts.port), timeout=30) as half,
    ):
        page.open()
        half.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\n")
        assert half.recv(100) == b""
        assert page.ask("older", before=10, count=1)["ok"]  # a page that says little stays
