"""The socket on which the observer of a run serves the graph."""

from __future__ import annotations

import json
import socket
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

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
