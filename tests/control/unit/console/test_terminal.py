"""Where there is a console."""

from __future__ import annotations

import os

import pytest

from launcher.control import console_process as console


@pytest.mark.parametrize(
    ("term", "is_one"), [("xterm", True), ("dumb", False), ("", False), (None, False)]
)
def test_a_terminal_without_a_type_has_no_console(monkeypatch, term: str | None, is_one: bool):
    monkeypatch.setattr(os, "isatty", lambda fd: True)
    monkeypatch.setattr(os, "tcgetpgrp", lambda fd: os.getpgrp())
    if term is None:
        monkeypatch.delenv("TERM", raising=False)
    else:
        monkeypatch.setenv("TERM", term)
    assert console.is_at_terminal() is is_one
