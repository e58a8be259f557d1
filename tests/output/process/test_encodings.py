"""Verbs where the locale has no Unicode, in real processes."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from launcher.base.verb_table import CONTROL_VERBS, VERBS
from tests.support.variations import few_of

ENVIRONMENTS = {
    "ascii": {"PYTHONIOENCODING": "ascii"},
    "latin-1": {"PYTHONIOENCODING": "latin-1"},
    "utf-8": {"PYTHONIOENCODING": "utf-8"},
    "C": {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
}
HELP_OF_ALL = """
import sys
from launcher.__main__ import main
for verb in {verbs}:
    sys.argv[1:] = [verb, "--help"]
    assert main() == 0, verb
"""


def run(name: str, *words: str) -> subprocess.CompletedProcess[bytes]:
    env = {key: value for key, value in os.environ.items() if key not in ("LANG", "LC_CTYPE")}
    env |= ENVIRONMENTS[name]
    return subprocess.run([sys.executable, *words], env=env, capture_output=True, timeout=60)


@pytest.mark.parametrize("name", few_of(ENVIRONMENTS, ["utf-8", "C"]))
def test_every_verb_prints_its_help(name):
    script = HELP_OF_ALL.format(verbs=[*VERBS, *CONTROL_VERBS])
    done = run(name, "-c", script)
    assert done.returncode == 0, done.stderr.decode()
    assert b"/fleet/tasks=1 Hz " in done.stdout  # of smoke, with a sign that ASCII lacks


@pytest.mark.parametrize("name", ["ascii", "C", "utf-8"])
def test_a_tree_is_drawn_with_the_characters_that_there_are(name):
    done = run(name, "-m", "launcher", "plan", "system")
    assert done.returncode == 0, done.stderr.decode()
    branch = "├──" if name == "utf-8" else "|--"
    assert f"\n{branch} argument enable_debug".encode() in done.stdout
