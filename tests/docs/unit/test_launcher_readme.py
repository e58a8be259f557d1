"""The README of the launcher's wheel: its verbs and extras exist."""

from __future__ import annotations

import re
from importlib import metadata

from launcher.cli.dispatch import CONTROL_VERBS, VERBS
from tests.support.repository import REPOSITORY

README = (REPOSITORY / "launcher/README.md").read_text(encoding="utf-8")


def test_every_verb_exists():
    named = set(re.findall(r"^launcher ([a-z]+)(?= |$)", README, re.M))

    assert {"demo", "plan", "doctor"} <= named
    assert named <= {*VERBS, *CONTROL_VERBS, "help"}


def test_every_extra_exists():
    named = set(re.findall(r"`([a-z]+)` \(", README))
    named |= set(",".join(re.findall(r"launcher\[([\w,]+)\]", README)).split(","))

    assert {"bag", "all", "jazzy"} <= named
    assert named <= {*metadata.metadata("ros2-launcher").get_all("Provides-Extra", ())}
