"""State machines of processes, in the states that tests begin with."""

import signal

from launcher.base.model.events import Outcome
from launcher.base.model.spec import RestartPolicy, StopPolicy
from launcher.run.processes.machine import ProcessMachine
from launcher.run.processes.machine_events import Exited, MachineCommand

INT, TERM, KILL = signal.SIGINT, signal.SIGTERM, signal.SIGKILL


def exited(code: int) -> Exited:
    return Exited(Outcome(returncode=code))


def machine(**restart: object) -> ProcessMachine:
    return ProcessMachine(RestartPolicy(**restart), StopPolicy(), chance=lambda: 0.5)


def running(**restart: object) -> ProcessMachine:
    one = machine(**restart)
    one.handle(MachineCommand.START, 0.0)
    one.handle(MachineCommand.STARTED, 0.0)
    return one
