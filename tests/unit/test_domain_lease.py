"""A lease on a ROS domain leaves alone what others use."""

from __future__ import annotations

import socket

from launcher.domain_lease import busy_domains, leased_domain


def test_two_leases_are_unlike():
    with leased_domain() as one, leased_domain() as two:
        assert one != two


def test_a_domain_whose_port_somebody_has_open_is_busy():
    with leased_domain() as domain_id, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        assert domain_id not in busy_domains()
        taken.bind(("127.0.0.1", 7400 + 250 * domain_id + 10))
        assert domain_id in busy_domains()
    assert domain_id not in busy_domains()
