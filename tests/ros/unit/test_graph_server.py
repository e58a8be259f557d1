"""The socket on which the observer of a run serves the graph."""

from __future__ import annotations

import contextlib
import json
import socket
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from launcher.ros.discovery import graph_server
from launcher.ros.discovery.graph_server import GraphServer


@pytest.fixture
def path(tmp_path: Path) -> Path:
    tmp_path.chmod(0o700)
    return tmp_path / "1-a.graph"


def echo(question: Mapping[str, Any]) -> Mapping[str, Any]:
    return {"asked": question}


def asked(path: Path) -> Any:
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as connection:
        connection.settimeout(60.0)
        connection.connect(str(path))
        connection.sendall(b'{"domain_id": 7}\n')
        return json.loads(connection.makefile().readline())


def test_a_question_is_answered_until_the_end(path: Path):
    server = GraphServer(path, echo)
    assert asked(path) == asked(path) == {"asked": {"domain_id": 7}}
    server.close()
    assert not path.exists()


def test_a_removed_socket_is_made_anew_and_one_that_is_there_stays(path: Path):
    server = GraphServer(path, echo)
    path.unlink()
    server.restore()
    made = path.stat().st_ino
    server.restore()
    assert path.stat().st_ino == made
    assert asked(path) == {"asked": {"domain_id": 7}}
    server.close()
    assert not path.exists()


def test_the_socket_is_not_created_again_after_the_end(path: Path):
    server = GraphServer(path, echo)
    server.close()
    server.restore()
    assert not path.exists()


@pytest.mark.parametrize(
    "sent",
    [b"[1]\n", b"[" * 60_000 + b"\n", b'{"domain_id": 1e999}\n', b"\xff\n", b'{"fail": 1}\n'],
    ids=["list", "deep", "infinite", "bytes", "error"],
)
def test_whatever_a_client_sends_the_next_one_is_answered(path: Path, sent: bytes):
    def answer(question: Mapping[str, Any]) -> Mapping[str, Any]:
        return {"asked": question, "domain": question["domain_id"]}

    server = GraphServer(path, answer)
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as connection:
        connection.settimeout(60.0)
        connection.connect(str(path))
        connection.sendall(sent)
        assert connection.recv(1) == b""
    assert asked(path)["domain"] == 7
    server.close()


def test_a_client_whose_request_never_ends_keeps_no_other_waiting(
    path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(graph_server, "REQUEST_TIMEOUT_S", 0.05)
    server = GraphServer(path, echo)
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as slow:
        slow.connect(str(path))
        with contextlib.suppress(BrokenPipeError, ConnectionResetError):
            for _ in range(graph_server._MAX_BYTES - 1):
                slow.sendall(b"x")
                slow.settimeout(0.001)
                with contextlib.suppress(TimeoutError):
                    assert slow.recv(1) == b""
                    break
            else:
                pytest.fail("the connection is open as long as bytes come")
        assert asked(path) == {"asked": {"domain_id": 7}}
    server.close()
