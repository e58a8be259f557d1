"""Kubernetes gives a process exactly the text of the launch file."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from launcher.export.kubernetes import literal

VARIABLES = {"A": "<a>", "B": "<b>", "KUBERNETES_PORT": "<port>"}


def replaced(text: str) -> str:
    """The text as a process gets it, by the rules of the Kubernetes API.

    `$(NAME)` is the value of a variable, unchanged if there is none of this name; `$$` is a dollar,
    also before a bracket.
    """
    done = ""
    while text:
        if text.startswith("$$"):
            done, text = f"{done}$", text[2:]
        elif text.startswith("$(") and ")" in text:
            name, _, text = text[2:].partition(")")
            done += VARIABLES.get(name, f"$({name})")
        else:
            done, text = done + text[0], text[1:]
    return done


PIECES = ("$", "(", ")", "A", "B", "$(A)", "$$", "$(date)", "x", "\n", "KUBERNETES_PORT")


@given(st.lists(st.sampled_from(PIECES), max_size=12).map("".join))
def test_nothing_is_replaced(text: str):
    assert replaced(literal(text, {"A", "B"})) == text


@pytest.mark.parametrize("text", ["5 $", "${A}", "$A", "$(date)", "$(date $(A $$)", "$(A", "$($A)"])
def test_what_stays_is_not_escaped(text: str):
    assert literal(text, {"A"}) == text
