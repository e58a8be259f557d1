"""A lab of hosts for each file of tests."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.support.hosts import Lab, needs_hosts


@pytest.fixture(scope="module")
def lab() -> Iterator[Lab]:
    """A bridge with an operator; tests add the hosts that they need, under names of their own."""
    needs_hosts()
    with Lab() as lab:
        yield lab
