"""Parameters of which `make test` tries a few."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

import pytest


def few_of(values: Iterable[Any], basic: Collection[Any]) -> list[Any]:
    """For `parametrize` with one name: all but the `basic` ones are `thorough`."""
    return [
        pytest.param(value, marks=() if value in basic else pytest.mark.thorough)
        for value in values
    ]
