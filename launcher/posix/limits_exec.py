"""Sets limits for its own process, then execs a program.

Called as `limits_exec.py FD SETTING ... -- PROGRAM ARG ...`. FD is closed on exec; an error is
written to FD before, as `ERRNO SETTING`. Settings are `nice=5`, `cpus=0,2`, `nofile=256/1024` (soft
and hard, -1 for no limit) and `unset=NAME` (a variable added by the interpreter of this script).
Started as a script with `-I -S`, which keeps it to a few milliseconds; so no other imports.
"""

from __future__ import annotations

import _signal  # type: ignore[import-not-found]  # `signal` without its enums, which take longer than all the rest
import errno
import os
import resource
import sys

FAILED = 127


def main() -> None:
    status = int(sys.argv[1])
    os.set_inheritable(status, False)
    end = sys.argv.index("--")
    program = sys.argv[end + 1 :]
    setting = ""
    try:
        for setting in sys.argv[2:end]:
            apply(setting)
        setting = ""
        for signum in (_signal.SIGPIPE, _signal.SIGXFSZ):
            _signal.signal(signum, _signal.SIG_DFL)  # the interpreter ignores them
        os.execvp(program[0], program)
    except OSError as error:
        os.write(status, f"{error.errno} {setting}".encode())
    except ValueError:  # what `resource` makes of EPERM and EINVAL
        os.write(status, f"{errno.EPERM} {setting}".encode())
    except MemoryError:
        os.write(status, f"{errno.ENOMEM} {setting}".encode())
    os._exit(FAILED)


def apply(setting: str) -> None:
    """Set one limit; OSError or ValueError if the system refuses."""
    name, _, text = setting.partition("=")
    if name == "unset":
        os.environ.pop(text, None)
    elif name == "nice":
        os.setpriority(os.PRIO_PROCESS, 0, int(text))
    elif name == "cpus":
        os.sched_setaffinity(0, [int(number) for number in text.split(",")])
    else:
        soft, _, hard = text.partition("/")
        resource.setrlimit(getattr(resource, f"RLIMIT_{name.upper()}"), (int(soft), int(hard)))


if __name__ == "__main__":
    main()
