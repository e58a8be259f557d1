"""The tables of docs/reference/faults.md are those of the code."""

from __future__ import annotations

import inspect
import re

from launcher.faults.causes import rules
from launcher.faults.checks import implied
from tests.support.repository import docs_page

PAGE = docs_page("faults")


def test_the_causes_are_the_rules_in_their_order():
    found = [
        (set(re.findall(r'rule="([^"]+)"', inspect.getsource(rule))), inspect.getdoc(rule))
        for rule in rules.RULES
    ]
    table = PAGE.partition("| rule | explains |")[2].partition("\n\n")[0]
    rows = re.findall(r"^\| (`.+`) \| (.+) \|$", table, re.M)

    assert [(set(re.findall("`([^`]+)`", names)), text) for names, text in rows] == [
        (names, (text or "").split("\n")[0]) for names, text in found
    ]


def test_the_implied_faults_are_in_the_table():
    source = inspect.getsource(implied)
    patterns = (r'origin\("([^"]+)"', r'fault="([^"]+)"', r'kind, expected = "([^"]+)"')
    kinds = {kind for pattern in patterns for kind in re.findall(pattern, source)}
    table = PAGE.partition("| fault | when |")[2].partition("\n\n")[0]

    assert {*re.findall(r"^\| `([^:`]+)", table, re.M)} == kinds
