"""Several hosts on this machine: network namespaces with sshd, and systemd in containers."""

from tests.support.hosts.computer import Computer, Process
from tests.support.hosts.host import Host
from tests.support.hosts.lab import Lab
from tests.support.hosts.operator import Operator
from tests.support.hosts.requirements import needs_clocks, needs_hosts, needs_robots
from tests.support.hosts.robot import Robot

__all__ = [
    "Computer",
    "Host",
    "Lab",
    "Operator",
    "Process",
    "Robot",
    "needs_clocks",
    "needs_hosts",
    "needs_robots",
]
