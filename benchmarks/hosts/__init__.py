"""Benchmarks of several hosts: namespaces with sshd, and systemd in containers, on this machine."""

from benchmarks.hosts.delay import delay
from benchmarks.hosts.first_line import first_line
from benchmarks.hosts.fleet import fleet
from benchmarks.hosts.flood import flood
from benchmarks.hosts.outage import outage
from benchmarks.hosts.scale import scale
from benchmarks.hosts.slow_link import slow_link
from benchmarks.hosts.units import units

__all__ = ["delay", "first_line", "fleet", "flood", "outage", "scale", "slow_link", "units"]
