"""Names of hosts, origins and tokens."""

from __future__ import annotations

import pytest

from launcher.web.access import Access, is_loopback

TOKEN = "correct-horse-battery"


@pytest.mark.parametrize(
    ("listening", "header", "known"),
    [
        ("127.0.0.1", "127.0.0.1:8770", True),
        ("127.0.0.1", "localhost", True),
        ("127.0.0.1", "LOCALHOST:1", True),
        ("127.0.0.1", "[::1]:8770", True),
        ("127.0.0.1", "192.168.1.5:8770", False),
        ("127.0.0.1", "evil.example", False),
        ("127.0.0.1", "localhost.evil.example", False),
        ("127.0.0.1", "evil.example@localhost:1", True),  # the name is localhost
        ("127.0.0.1", "localhost@evil.example", False),
        ("127.0.0.1", "", False),
        ("127.0.0.1", None, False),
        ("127.0.0.1", "[::1", False),
        ("0.0.0.0", "192.168.1.5:8770", True),
        ("0.0.0.0", "[fe80::1]:8770", True),
        ("0.0.0.0", "evil.example", False),
        ("robot.local", "robot.local:8770", True),
        ("robot.local", "evil.example", False),
    ],
)
def test_hosts(listening: str, header: str | None, known: bool):
    assert Access(TOKEN, listening, secure=False).is_known_host(header) is known


@pytest.mark.parametrize(
    ("origin", "host", "same"),
    [
        ("http://localhost:8770", "localhost:8770", True),
        ("http://localhost:8771", "localhost:8770", False),
        ("https://localhost:8770", "localhost:8770", False),
        ("null", "localhost:8770", False),
        (None, "localhost:8770", False),
        ("http://localhost:8770", None, False),
        ("http://evil.example", "localhost:8770", False),
    ],
)
def test_origins(origin: str | None, host: str | None, same: bool):
    assert Access(TOKEN, "127.0.0.1", secure=False).is_same_origin(origin, host) is same


@pytest.mark.parametrize("given", [None, "", TOKEN[:-1], TOKEN + "x", TOKEN.upper(), "ü"])
def test_other_tokens_are_refused(given: str | None):
    access = Access(TOKEN, "127.0.0.1", secure=False)

    assert not access.is_token(given)
    assert access.is_token(TOKEN)


def test_the_cookie_of_one_run_is_not_that_of_another():
    one = Access(TOKEN, "127.0.0.1", secure=False)
    other = Access("battery-staple-horse", "127.0.0.1", secure=False)
    name, _, value = one.cookie().partition(";")[0].partition("=")

    assert one.has_cookie({name: value})
    assert not other.has_cookie({name: value})
    assert other.cookie().partition("=")[0] != name
    # A server that was started again for the same run knows it.
    assert Access(TOKEN, "127.0.0.1", secure=False).has_cookie({name: value})


@pytest.mark.parametrize(
    ("host", "loopback"),
    [
        ("127.0.0.1", True),
        ("127.9.9.9", True),
        ("::1", True),
        ("localhost", True),
        ("0.0.0.0", False),
        ("::", False),
        ("192.168.1.1", False),
        ("robot.local", False),
    ],
)
def test_loopback(host: str, loopback: bool):
    assert is_loopback(host) is loopback
