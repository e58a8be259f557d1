"""Fixtures of the node tests: a private domain per test or per module."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

pytest.importorskip("rclpy")

from tests.support.domain import Domain, private_domain


@pytest.fixture
def domain(tmp_path) -> Iterator[Domain]:
    """A domain for one test."""
    with private_domain(tmp_path) as one:
        yield one


@pytest.fixture(scope="module")
def module_domain(tmp_path_factory) -> Iterator[Domain]:
    """A domain that the tests of a module share."""
    with private_domain(tmp_path_factory.mktemp("ros_log")) as one:
        yield one
