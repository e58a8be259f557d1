"""Names that systemd and Kubernetes accept: legal, unique, and those that users guess."""

from __future__ import annotations

import hashlib
import re
from collections import Counter
from collections.abc import Sequence

from launcher.base.model.record import Record
from launcher.base.model.spec import ProcessSpec

MAX_DNS_LABEL = 63
# Names that get suffixes of up to this length: of a file, a generated pod, a timer.
_MAX = MAX_DNS_LABEL - 12
_DIGEST = 6
# Units of nearly every system: a node of this name must not replace them.
_UNITS = """
acpid anacron apparmor atd auditd avahi-daemon basic bluetooth chrony chronyd containerd cron
crond cups dbus default docker emergency firewalld getty gdm graphical greetd halt initrd iptables
irqbalance kexec kubelet lightdm local-fs multi-user network network-online networking nftables
nginx nss-lookup paths plymouth podman polkit poweroff printer rc-local reboot remote-fs rescue
resolvconf rsyslog shutdown sleep slices smartd snapd sockets sound ssh sshd sssd sudo suspend
swap sysinit syslog time-set time-sync timers tuned udev udisks2 ufw umount upower user usbmuxd
wpa_supplicant
"""
_OF_THE_SYSTEM = frozenset(_UNITS.split())
MAX_PREFIX = 32  # so that of long names something is left after it
_PREFIX = re.compile(r"[A-Za-z][A-Za-z0-9_.-]*")


class Name(Record):
    """`unit` as in `robot_1.service`, `label` as in `deploy/robot-1`."""

    unit: str
    label: str


def is_prefix(text: str) -> bool:
    """Whether names can begin with the text as it is; in DNS labels it is written like the rest."""
    return not text or (len(text) <= MAX_PREFIX and _PREFIX.fullmatch(text) is not None)


def names_of(specs: Sequence[ProcessSpec], prefix: str = "") -> list[Name]:
    """A name for each process, with the namespace or a number where several share it."""
    texts = _distinct(specs)
    units = _unique([_free(unit_name(prefix + text)) for text in texts])
    labels = _unique([dns_label(prefix + text) for text in texts])
    return [Name(unit=unit, label=label) for unit, label in zip(units, labels, strict=True)]


def name_of_system(stem: str, prefix: str = "") -> Name:
    return Name(unit=_free(unit_name(prefix + stem)), label=dns_label(prefix + stem))


def unit_name(text: str) -> str:
    """The text as name of a systemd unit, without its suffix."""
    return _short(re.sub(r"[^A-Za-z0-9_.-]+", "-", text).strip("-."), text) or "process"


def dns_label(text: str) -> str:
    """The text as a DNS label: lower case letters, digits and `-`, which begins with a letter."""
    label = re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")
    if not label[:1].isalpha():
        label = f"p-{label}".rstrip("-") if label else "process"
    return _short(label, text)


def file_name(text: str) -> str:
    """The text as name of a file, and as key of a ConfigMap."""
    name = re.sub(r"[^A-Za-z0-9_.-]+", "-", text).strip("-") or "file"
    return _short(name if name.strip(".") else "file", text)


def _short(name: str, text: str) -> str:
    """At most _MAX characters; a digest of the whole text makes cut names distinct."""
    if len(name) <= _MAX:
        return name
    digest = hashlib.sha256(text.encode(errors="surrogateescape")).hexdigest()[:_DIGEST]
    return f"{name[: _MAX - _DIGEST - 1].rstrip('-._')}-{digest}"


def _free(name: str) -> str:
    is_taken = name.lower() in _OF_THE_SYSTEM or name.startswith(("systemd-", "dbus-"))
    return f"{name}-node" if is_taken else name


def _distinct(specs: Sequence[ProcessSpec]) -> list[str]:
    """The name of each node, with its namespace if another one has it; the label of others."""
    short = [_parts(spec)[1] for spec in specs]
    seen = Counter(short)
    return [
        name if seen[name] == 1 else "-".join(filter(None, _parts(spec)))
        for name, spec in zip(short, specs, strict=True)
    ]


def _parts(spec: ProcessSpec) -> tuple[str, str]:
    """(namespace, name)."""
    if spec.ros is None:
        return "", spec.label
    full = f"{(spec.ros.namespace or '').strip('/')}/{spec.ros.node_name or spec.label}"
    namespace, _, name = full.rpartition("/")
    return namespace.strip("/"), name


def _unique(names: Sequence[str]) -> list[str]:
    taken: set[str] = set(names)
    return [_first_free(name, names[:place], taken) for place, name in enumerate(names)]


def _first_free(name: str, before: Sequence[str], taken: set[str]) -> str:
    if name not in before:
        return name
    number = 2
    while f"{name}-{number}" in taken:
        number += 1
    taken.add(f"{name}-{number}")
    return f"{name}-{number}"
