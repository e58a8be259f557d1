"""Compares what `--json` printed with the table of forms."""

from __future__ import annotations

import json
from typing import Any

from tools.json_forms import all_forms, form_of
from tools.json_keys import faults_of, keys_in

VERBS = [verb for form in all_forms() for verb in form.verbs]


def fit(verb: str, out: str) -> list[dict[str, Any]]:
    """The answers that a verb printed; AssertionError if they are not as the table says."""
    form = form_of(verb)
    answers = [json.loads(line) for line in out.splitlines()] if form.lines else [json.loads(out)]
    assert answers, f"{verb} printed nothing"
    for answer in answers:
        assert answer.pop("version") == 1, f"{verb}: {answer}"
        fit_answer(verb, answer)
    return answers


def fit_result(verb: str, result: dict[str, Any]) -> None:
    """The same for an answer of the control socket, if its verb has a form of one object."""
    if verb in VERBS and not form_of(verb).lines:
        fit_answer(verb, {key: value for key, value in result.items() if key != "version"})


def fit_answer(verb: str, answer: object) -> None:
    """The same for one answer without its version."""
    kinds = [list(faults_of(answer, keys_in(text))) for text in form_of(verb).kinds]
    assert [] in kinds, f"{verb}: {min(kinds, key=len)} in {answer}"
