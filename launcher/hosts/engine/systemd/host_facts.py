"""What is asked of a host at login, and whether its systemd can be used."""

from __future__ import annotations

import re
import shlex

from launcher.base import strict_json
from launcher.base.model.record import Record
from launcher.hosts import unit
from launcher.hosts.file.hosts_model import Host
from launcher.hosts.ssh import set_python, setup_script


class HostFacts(Record):
    """The answer of a host to HELLO."""

    uid: int
    user: str
    home: str
    runtime: str  # the folder of the runtime files of its user
    version: int  # of systemd; 0: there is none
    state: str  # of the service manager; empty: it does not answer
    lingers: bool
    boot_id: str
    uptime_s: float
    cursor: str | None
    has_launcher: bool  # whether the host's Python finds it
    python: str  # that Python: what `hosts sync` brought, else that of the hosts file
    installed: tuple[str, ...] = ()  # what `--enable` has installed for this user
    lacks_python: bool = False  # it is not there
    is_booted: bool = True  # with systemd, as far as the service manager says so

    @property
    def is_user(self) -> bool:
        """Whether units run under the manager of a user."""
        return self.uid != 0


_OFFLINE = "offline"  # what systemctl says where the machine was not booted with systemd
HELLO = r"""
uid=$(id -u)
echo "uid $uid"
echo "user $(id -un)"
echo "home $HOME"
echo "runtime ${XDG_RUNTIME_DIR:-/run/user/$uid}"
manager=--user
[ "$uid" = 0 ] && manager=--system
echo "version $(systemctl --version 2>/dev/null | { read -r _ number _; echo "$number"; })"
echo "state $(systemctl $manager is-system-running 2>/dev/null)"
[ -e "/var/lib/systemd/linger/$(id -un)" ] && echo "lingers 1"
read -r boot </proc/sys/kernel/random/boot_id
echo "boot_id $boot"
read -r up _ </proc/uptime
echo "uptime_s $up"
base=$HOME/.config
[ "$uid" = 0 ] && base=/etc
for one in "$base"/launcher/*/installed; do
  one=${one%/installed}
  [ -d "$one" ] && echo "installed ${one##*/}"
done
echo "entry $(journalctl --quiet --lines=1 --output=json --output-fields=_BOOT_ID 2>/dev/null)"
"""


def hello(host: Host) -> str:
    """Asks for the facts."""
    code = "import launcher.hosts.file.run_order; print('yes')"
    chosen = set_python(host)
    look = 'command -v "$python" >/dev/null || echo no python; '
    python = f'{setup_script(host)}{chosen}{look}"$python" -c {shlex.quote(code)}'
    return (
        f'{HELLO}echo "python $(cd && {chosen}printf %s "$python")"\n'
        f'echo "launcher $( ({python}) 2>/dev/null | tail -n 1)"'
    )


def read_facts(text: str) -> HostFacts:
    """ValueError if this is no answer of HELLO."""
    pairs = [line.partition(" ")[::2] for line in text.splitlines()]
    found = dict(pairs)
    entry = found.get("entry", "")
    state = found.get("state", "")
    uid = int(found["uid"])
    version = re.match(r"\d+", found["version"])
    return HostFacts(
        uid=uid,
        user=found["user"],
        home=found["home"],
        runtime="/run" if uid == 0 else found["runtime"],
        version=int(version[0]) if version else 0,
        state="" if state == _OFFLINE else state,
        lingers="lingers" in found,
        boot_id=found["boot_id"],
        uptime_s=float(found["uptime_s"]),
        cursor=strict_json.loads(entry)["__CURSOR"] if entry.startswith("{") else None,
        has_launcher=found.get("launcher", "") == "yes",
        python=found["python"],
        installed=tuple(value for key, value in pairs if key == "installed"),
        lacks_python=found.get("launcher", "") == "no python",
        is_booted=state != _OFFLINE,
    )


def why_unusable(facts: HostFacts) -> str:
    """Why its systemd cannot be used, and what to do; empty if it can."""
    if facts.version == 0:
        return "does not have systemd: install it"
    if facts.version < unit.OLDEST:
        return f"has systemd {facts.version}: install {unit.OLDEST} or newer"
    if not facts.is_booted:
        return "was not booted with systemd: boot it with systemd"
    if not facts.state and not facts.is_user:
        return "its service manager does not answer: look at systemctl status there"
    if not facts.state:
        return f"the service manager of {facts.user} does not answer: install libpam-systemd there"
    return ""
