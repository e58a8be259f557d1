"""`talker` names the process of talker.py wherever a process is named."""

from __future__ import annotations

import pytest

from launcher.base.model.run_options import RunOptions, matches, names_of
from launcher.base.model.spec import ProcessSpec, RestartMode, RestartPolicy
from launcher.run.monitor.budget_parser import parse_words
from launcher.run.requests.process_selection import ProcessNames, resolve
from launcher.smoke.observe.facts import matches as expected


def spec_of(label: str) -> ProcessSpec:
    return ProcessSpec(name=f"{label}-1", label=label, argv=(label,), env={})


@pytest.mark.parametrize("word", ["talker", "talk*", "talker.py", "talker.py-1"])
def test_options_find_it(word: str):
    spec = spec_of("talker.py")
    policy = RestartPolicy(RestartMode.ON_FAILURE)
    assert RunOptions(restart=((word, policy),)).adapt(spec).restart is policy
    assert RunOptions(required=(word,)).is_required(spec)
    (budget,) = parse_words([f"{word}:memory=1M"])
    assert budget.covers(spec.name, names_of(spec))
    assert expected(word, spec.name, ())
    assert resolve([word], [ProcessNames.of(spec)]) == [0]


def test_other_suffixes_are_part_of_the_name():
    assert not matches("talker", spec_of("talker.exe"))
