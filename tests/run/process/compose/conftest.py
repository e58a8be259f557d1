"""A bench with a ROS domain of its own."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from launcher.posix.domain_lease import leased_domain
from tests.support.benches import ControlBench


@pytest.fixture
def bench(control_bench: ControlBench) -> Iterator[ControlBench]:
    with leased_domain() as domain_id:
        control_bench.env["ROS_DOMAIN_ID"] = str(domain_id)
        control_bench.env["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
        yield control_bench
        assert control_bench.survivors() == []
