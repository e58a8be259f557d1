"""What the shell on a host runs: scripts of the POSIX shell, everything in them quoted.

Each may be run twice, since a link may break before its answer comes.
"""

from __future__ import annotations

import base64
import shlex
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from launcher.base import strict_json
from launcher.hosts import unit
from launcher.hosts.engine.systemd import journal
from launcher.hosts.engine.systemd.host_facts import HostFacts
from launcher.hosts.file.hosts_model import Host
from launcher.hosts.file.order import Order
from launcher.hosts.file.order_words import as_words, files_of
from launcher.hosts.ssh import quoted, setup_script

LONGEST_STOP_S = 10  # of a unit of the same name, which a start waits for
_SHOWN = "Id,LoadState,ActiveState,SubState,Result,MainPID,NRestarts,InvocationID"
_SHOWN_MORE = "ExecMainPID,ExecMainCode,ExecMainStatus,ExecMainStartTimestampMonotonic"


class Scripts:
    """The scripts for the units of a run on a host."""

    def __init__(self, run: str, host: Host, facts: HostFacts) -> None:
        self._run = run
        self._host = host
        self._facts = facts
        self.folder = f"{facts.runtime}/launcher/{run}"
        self._folder = shlex.quote(self.folder)
        self._systemctl = "systemctl --user" if facts.is_user else "systemctl"
        self._slice = unit.slice_name(run)

    def unit(self, name: str) -> str:
        return unit.unit_name(self._run, name)

    # ---- files

    def prepare(self) -> str:
        """Makes the private folder and the scripts that all units share."""
        record = f"systemd-cat -t {journal.records_identifier(self._run)} echo"
        # What a short process has written may not even have been looked at, and without its unit
        # the journal would apply its general limit of lines.
        settle = "" if self._facts.is_user else SETTLE.format(folder=self._folder)
        end = (
            f'{settle}exec {record} exit "$1" "$INVOCATION_ID" "${{SERVICE_RESULT:--}}"'
            ' "${EXIT_CODE:--}" "${EXIT_STATUS:--}"\n'
        )
        return "\n".join(
            [
                "umask 077",
                f"mkdir -p {self._folder} && chmod 700 {self._folder} || exit",
                written(f"{self.folder}/end", end.encode()),
                written(f"{self.folder}/may-start", b'[ ! -e "$1" ]\n'),
            ]
        )

    def files(self, process_id: int, order: Order) -> str:
        """Writes the files of a process: environment, script, and those that it is sent."""
        folder = f"{self.folder}/{process_id}"
        fits = {k: v for k, v in order.environment.items() if unit.fits_environment_file(k, v)}
        lines = [
            "umask 077",
            f"mkdir -p {shlex.quote(folder)}",
            f"[ -p {shlex.quote(folder)}/stdin ] || mkfifo {shlex.quote(folder)}/stdin",
            written(f"{folder}/environment", unit.environment_file(fits).encode()),
            written(f"{folder}/start", self._start_file(process_id, order)),
        ]
        if not all(map(unit.is_variable, order.environment)):
            lines.append(written(f"{folder}/{_UNNAMEABLE}", _unnameable(order)))
        lines += [written(f"{folder}/{name}", data) for name, data in files_of(order).items()]
        return "\n".join(lines)

    def _start_file(self, process_id: int, order: Order) -> bytes:
        """The script that becomes the process: `$$` stays its pid."""
        facts, folder = self._facts, f"{self.folder}/{process_id}"
        records = journal.records_identifier(self._run)
        home = {"HOME": facts.home, "USER": facts.user, "LOGNAME": facts.user}
        # The system's manager passes the unit of a stream to the journal, a user's does not.
        announced = [f"echo {quoted([journal.announcement(process_id)])}"] if facts.is_user else []
        lines = [
            *announced,
            f'systemd-cat -t {records} echo start {process_id} "$INVOCATION_ID" $$',
            f'read -r up _ </proc/uptime; echo "${{up%%.*}}" >{shlex.quote(folder)}/began',
            f"exec <>{shlex.quote(folder)}/stdin",
            *(f': "${{{k}:={v}}}"; export {k}' for k, v in _safe(home).items()),
            setup_script(self._host).rstrip("; "),
        ]
        if self._host.setup:
            lines.append(f"set -a; . {shlex.quote(folder)}/environment; set +a")
        for name, value in order.environment.items():
            if unit.is_variable(name) and not unit.fits_environment_file(name, value):
                lines.append(f"export {shlex.quote(f'{name}={value}')}")
        if order.unset:
            lines.append(f"unset -v {quoted(n for n in order.unset if n.isidentifier())} || :")
        if order.cwd is not None:
            lines.append(f"cd {shlex.quote(order.cwd)} || exit 200")
        words = as_words(order, python=self._python, folder=folder)
        if not all(map(unit.is_variable, order.environment)):
            words = (self._python, "-ISc", _WITH_VARIABLES, f"{folder}/{_UNNAMEABLE}", *words)
        lines.append(f"exec {quoted((*self._apart(process_id, order), *words))}")
        return "\n".join([*lines, ""]).encode("utf-8", "surrogateescape")

    @property
    def _python(self) -> str:
        """Usable in any folder."""
        python = self._facts.python
        return f"{self._facts.home}/{python}" if python.startswith("./") else python

    def _apart(self, process_id: int, order: Order) -> Sequence[str]:
        """What gives each stream a priority, if they must be distinguished.

        The journal has no unit for such a stream, if a child writes that has ended.
        """
        if order.merge:
            return ()
        return (
            *("systemd-cat", f"--identifier={journal.identifier(self._run)}"),
            f"--priority={journal.STDOUT_PRIORITY}",
            f"--stderr-priority={journal.STDERR_PRIORITY}",
            "--level-prefix=false",
            *("/bin/sh", "-c", _ANNOUNCED, "sh", journal.announcement(process_id)),
        )

    # ---- units

    def start(self, process_id: int, order: Order, token: str) -> str:
        """Starts the unit, unless it was started with this token before; prints its state."""
        name, folder = shlex.quote(self.unit(order.name)), f"{self.folder}/{process_id}"
        token_file = f"{shlex.quote(folder)}/token"
        run = quoted(self.start_words(process_id, order))
        return f"""
code=0
if [ "$(cat {token_file} 2>/dev/null)" != {token} ]; then
  rm -f {shlex.quote(folder)}/hold
  tries=0
  while :; do
    said=$({run} 2>&1); code=$?
    case $said in
      *"already loaded"*|*"fragment file"*) ;;
      *) break ;;
    esac
    if [ "$({self._systemctl} show -p ActiveState --value {name})" = active ]; then
      code=0; break
    fi
    {self._systemctl} stop {name} 2>/dev/null
    {self._systemctl} reset-failed {name} 2>/dev/null
    tries=$((tries + 1)); [ $tries -lt {LONGEST_STOP_S * 10} ] || break
    sleep 0.1
  done
  echo {token} > {token_file}
  if [ $code != 0 ]; then
    [ -n "$said" ] || said=$({self._systemctl} show -p ExecMainStatus {name})
    printf '%s\\n' "$said"
  fi
fi
[ $code != 0 ] || {self._systemctl} show -p {_SHOWN},{_SHOWN_MORE} {name}
exit $code"""

    def start_words(self, process_id: int, order: Order) -> list[str]:
        """The command line of systemd-run."""
        folder = f"{self.folder}/{process_id}"
        settings, _ = unit.supported(
            unit.process_settings(order.restart, order.stop, order.limits), self._facts.version
        )
        properties = [
            *map(str, settings),
            f"SyslogIdentifier={journal.identifier(self._run)}",
            f"EnvironmentFile={folder}/environment",
            f"ExecStopPost=-/bin/sh {self.folder}/end {process_id}",
            "CPUAccounting=yes",
            "MemoryAccounting=yes",
            "TasksAccounting=yes",
        ]
        if "Restart=no" not in properties:
            properties.append(f"ExecCondition=/bin/sh {self.folder}/may-start {folder}/hold")
        return [
            *("systemd-run", *(["--user"] if self._facts.is_user else []), "--quiet"),
            f"--unit={self.unit(order.name)}",
            f"--slice={self._slice}",
            f"--description={order.name} of launcher run {self._run}",
            "--service-type=exec",
            *(f"--property={one}" for one in properties),
            *("/bin/sh", f"{folder}/start"),
        ]

    def stop(self, name: str) -> str:
        """Begins to stop the unit, also while it waits for its restart."""
        return f"{self._systemctl} stop --no-block {shlex.quote(self.unit(name))}"

    def signal(self, name: str, signum: int) -> str:
        return f"{self._systemctl} kill --signal={int(signum)} {shlex.quote(self.unit(name))}"

    def hold(self, process_id: int) -> str:
        """An exit that follows is not one that systemd restarts after."""
        return f": >{shlex.quote(f'{self.folder}/{process_id}/hold')}"

    def release(self, process_id: int) -> str:
        return f"rm -f {shlex.quote(f'{self.folder}/{process_id}/hold')}"

    def write_stdin(self, process_id: int, data: bytes) -> str:
        """The FIFO has a reader that never blocks us as long as it is not full."""
        encoded = base64.b64encode(data).decode()
        fifo = shlex.quote(f"{self.folder}/{process_id}/stdin")
        return f"printf %s {encoded} | base64 -d | timeout 1 dd of={fifo} conv=nocreat 2>/dev/null"

    def show(self, names: Iterable[str]) -> str:
        """Prints the states of units, a paragraph each."""
        units = quoted(map(self.unit, names))
        return f"{self._systemctl} show -p {_SHOWN},{_SHOWN_MORE} -- {units}"

    def mark(self, token: str) -> str:
        """Writes a record: everything that is before it in the journal has come when it comes."""
        return f"systemd-cat -t {journal.records_identifier(self._run)} echo mark {token}"

    # ---- the run

    def manifest(self, document: Mapping[str, Any]) -> str:
        """Writes what `attach` needs to know about the run."""
        text = strict_json.packed(document, sort_keys=True).encode()
        return f"umask 077\n{written(f'{self.folder}/manifest', text)}"

    def watch(self, stop_after_s: float) -> str:
        """Starts a unit that stops the run if no beat comes for so long."""
        script = WATCH.format(
            seconds=f"{stop_after_s:g}",
            hundredths=round(100 * stop_after_s),
            beat=shlex.quote(f"{self.folder}/beat"),
            record=f"systemd-cat -t {journal.records_identifier(self._run)} echo",
            stop=f"{self._systemctl} stop {shlex.quote(self._slice)}",
        )
        scope = " --user" if self._facts.is_user else ""
        name = shlex.quote(self.watch_unit)
        return "\n".join(
            [
                f"{self.beat()}\n",
                written(f"{self.folder}/watch", script.encode()),
                f"{self._systemctl} is-active --quiet {name} || systemd-run{scope} --quiet"
                f" --collect --unit={name}"
                f" --description='watch of launcher run {self._run}'"
                f" /bin/sh {self._folder}/watch",
            ]
        )

    @property
    def watch_unit(self) -> str:
        return unit.unit_name(self._run, "watch!")

    def beat(self) -> str:
        """Reports to the watch that the operator is there."""
        beat = shlex.quote(f"{self.folder}/beat")
        return f'read -r up _ </proc/uptime; echo "${{up%.*}}${{up#*.}}" >{beat}'

    def finish(self, names: Iterable[str], by: str, *, at_once: bool) -> str:
        """Stops what is left, and removes all traces; prints the units that were still active.

        `by` is recorded in the journal for launchers of other operators.
        """
        units = quoted(map(self.unit, names)) or shlex.quote(self._slice)
        group = shlex.quote(self._slice)
        kill = f"{self._systemctl} kill --signal=9 {group} 2>/dev/null" if at_once else ":"
        return f"""
systemd-cat -t {journal.records_identifier(self._run)} echo ended {shlex.quote(by)}
{self._systemctl} list-units --plain --no-legend --state=active,deactivating,activating \
  {units} 2>/dev/null | while read -r one _; do printf '%s\\n' "$one"; done
{self._systemctl} stop {shlex.quote(self.watch_unit)} 2>/dev/null
{kill}
{self._systemctl} stop {group} 2>/dev/null
{self._systemctl} reset-failed {units} 2>/dev/null
rm -rf {self._folder}
rmdir {shlex.quote(f"{self._facts.runtime}/launcher")} 2>/dev/null
exit 0"""


_ANNOUNCED = 'echo "$1"; echo "$1" >&2; shift; exec "$@"'

# Variables whose names no shell takes, and the program of a Python that takes them.
_UNNAMEABLE = "variables.json"
_WITH_VARIABLES = """\
import json, os, signal, sys
for number in (signal.SIGPIPE, signal.SIGXFSZ):
    signal.signal(number, signal.SIG_DFL)
with open(sys.argv[1]) as file:
    found = json.load(file).items()
for name, value in found:
    os.environb[name.encode("utf-8", "surrogateescape")] = value.encode("utf-8", "surrogateescape")
try:
    os.execvp(sys.argv[2], sys.argv[2:])
except OSError as error:
    sys.exit(f"{sys.argv[2]}: {error.strerror}")
"""


def _unnameable(order: Order) -> bytes:
    found = {k: v for k, v in order.environment.items() if not unit.is_variable(k)}
    return strict_json.packed(found).encode()


SETTLE = """\
read -r up _ </proc/uptime
read -r began <{folder}/"$1"/began
[ $((${{up%%.*}} - ${{began:-0}})) -gt 2 ] || timeout 3 journalctl --sync 2>/dev/null
"""
# The time of a beat is in hundredths of a second, as in /proc/uptime: in whole ones, a beat of a
# second ago may look like one of two.
WATCH = """\
while sleep 1; do
  read -r now _ </proc/uptime
  read -r beat <{beat} || continue
  [ $((${{now%.*}}${{now#*.}} - beat)) -lt {hundredths} ] && continue
  {record} expired {seconds}
  {stop}
  exit
done
"""


def _safe(variables: Mapping[str, str]) -> dict[str, str]:
    """Values for a shell's `${NAME:=VALUE}` in double quotes."""
    table = str.maketrans({char: f"\\{char}" for char in '"\\`$}'})
    return {name: value.translate(table) for name, value in variables.items()}


def written(path: str, content: bytes) -> str:
    """Writes a file in one step; the content is in no command line."""
    place, new = shlex.quote(path), shlex.quote(f"{path}.new")
    encoded = base64.encodebytes(content).decode()
    return f"base64 -d >{new} <<'E' && mv {new} {place}\n{encoded}E\n"


def read_properties(text: str) -> list[dict[str, str]]:
    """The paragraphs of `systemctl show`."""
    return [
        dict(line.partition("=")[::2] for line in paragraph.splitlines() if "=" in line)
        for paragraph in text.split("\n\n")
        if "=" in paragraph
    ]
