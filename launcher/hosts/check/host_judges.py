"""What is wrong on a host by itself: each function goes from its facts to findings."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from launcher.base.model.level import Level
from launcher.base.program import program
from launcher.base.text import count
from launcher.hosts.check.host_findings import CheckedHost, HostFinding
from launcher.hosts.file.hosts_model import LOCAL, HostEngine

MB = 1024**2
MIN_PYTHON = (3, 10)
MIN_FREE_BYTES = 200 * MB
MIN_FREE_INODES = 1000
MIN_SHM_BYTES = 8 * MB  # a dozen nodes
MIN_SESSIONS = 4  # of systemd's engine two, and one each for `hosts sync` and a user
NOTED_CLOCK_S = 0.01
WRONG_CLOCK_S = 1.0
SHM = "/dev/shm"

Judge = Callable[[CheckedHost], Iterator[HostFinding]]


def check_member(member: CheckedHost) -> list[HostFinding]:
    """All findings about one host, or about this machine."""
    if member.error is not None:
        text = member.error.message.removeprefix(f"host '{member.name}': ")
        return [problem("reach", member, text, member.error.hint or "see `ssh -v`")]
    judges = _OF_EVERY if member.name == LOCAL else (*_OF_HOSTS, *_OF_EVERY)
    return [finding for judge in judges for finding in judge(member)]


def problem(check: str, member: CheckedHost, text: str, advice: str) -> HostFinding:
    names = (member.name,)
    return HostFinding(check=check, hosts=names, level=Level.PROBLEM, text=text, advice=advice)


def note(check: str, member: CheckedHost, text: str, advice: str) -> HostFinding:
    return HostFinding(
        check=check, hosts=(member.name,), level=Level.NOTE, text=text, advice=advice
    )


def sync_command(member: CheckedHost) -> str:
    path = member.host.where.rpartition(":")[0] if member.host else ""
    return f"{program()} hosts sync" + (f" --hosts {path}" if path else "")


def engine_of(member: CheckedHost) -> HostEngine:
    """The engine that a run would use."""
    assert member.host is not None
    if member.host.engine is not HostEngine.AUTO:
        return member.host.engine
    has_systemd = member.facts["systemd"] and member.facts["manager"]
    return HostEngine.SYSTEMD if has_systemd else HostEngine.SSH


def _engine(member: CheckedHost) -> Iterator[HostFinding]:
    if engine_of(member) is not HostEngine.SYSTEMD:
        return
    if not member.facts["systemd"]:
        yield problem(
            "engine",
            member,
            "engine is systemd, but the machine was not booted with systemd",
            "write `engine: ssh` in the hosts file",
        )
    elif not member.facts["manager"]:
        yield problem(
            "engine",
            member,
            f"systemd has no manager for user {member.user}",
            f"loginctl enable-linger {member.user}, as root there; or `engine: ssh`",
        )
    elif not member.facts["lingers"]:
        yield problem(
            "engine",
            member,
            f"systemd ends the processes of {member.user} with the last session of this user: "
            "a lost link would stop the nodes",
            f"loginctl enable-linger {member.user}, as root there; or `engine: ssh`",
        )


def _python(member: CheckedHost) -> Iterator[HostFinding]:
    version = tuple(member.facts["python"])
    if version[:2] < MIN_PYTHON:
        found, least = ".".join(map(str, version)), ".".join(map(str, MIN_PYTHON))
        yield problem(
            "python",
            member,
            f"Python {found} is too old: the launcher needs {least}",
            "name a newer one with `python:` in the hosts file",
        )


def _launcher(member: CheckedHost) -> Iterator[HostFinding]:
    if member.facts["version"] is None:
        text = f"{member.facts['executable']} has no launcher"
        yield problem("launcher", member, text, f"{sync_command(member)} installs it")


def _packages(member: CheckedHost) -> Iterator[HostFinding]:
    missing = member.facts["missing"]
    gone = missing["packages"]
    if member.facts["unchecked"] and member.needs.count:
        text = f"its launcher cannot look for the packages of the plan: {member.facts['unchecked']}"
        yield problem("packages", member, text, sync_command(member))
    texts = [f"package {name}" for name in gone]
    texts += [f"{name} of {pkg}" for pkg, name in missing["executables"] if pkg not in gone]
    texts += [f"message package {name}" for name in missing["interfaces"] if name not in gone]
    if texts:
        yield problem("packages", member, f"not found: {', '.join(texts)}", sync_command(member))


def _clock(member: CheckedHost) -> Iterator[HostFinding]:
    clock = member.clock
    if clock is None:
        return
    least_s = abs(clock.offset_s) - clock.uncertainty_s
    if least_s < NOTED_CLOCK_S:
        return
    direction = "ahead of" if clock.offset_s > 0 else "behind"
    text = (
        f"its clock is {duration(abs(clock.offset_s))} {direction} this machine's "
        f"(± {duration(clock.uncertainty_s)})"
    )
    if least_s < WRONG_CLOCK_S:
        text += ": ages of messages and the order of log lines are off by as much"
        yield note("clock", member, text, _TIME)
    else:
        text += ": ages and rates of messages are wrong, and a backlog looks new or has no end"
        yield problem("clock", member, text, _TIME)


_TIME = "run chrony or systemd-timesyncd on both; `timedatectl` shows whether one is in step"


def duration(seconds: float) -> str:
    return f"{seconds:.1f} s" if seconds >= 1 else f"{seconds * 1000:.1f} ms"


def _folders(member: CheckedHost) -> Iterator[HostFinding]:
    for folder in member.facts["folders"]:
        path = folder["path"]
        if "error" in folder:
            text = f"{path}: {folder['error']}"
            yield problem("disk", member, text, f"look at {folder['existing']} there")
            continue
        # This machine's /dev/shm is doctor's.
        least = MIN_SHM_BYTES if path == SHM else MIN_FREE_BYTES
        if folder["free"] < least:
            text = f"{folder['free'] / MB:.0f} MiB are free where {path} is"
            repair = f"{program()} doctor --fix, there" if path == SHM else "remove files there"
            yield problem("disk", member, text, repair)
        elif folder["inodes"] and folder["free_inodes"] < MIN_FREE_INODES:
            are = "is" if folder["free_inodes"] == 1 else "are"
            text = f"{count(folder['free_inodes'], 'inode')} {are} free where {path} is"
            yield problem("disk", member, text, "remove small files there")
        if not folder["writable"]:
            text = f"{member.user or 'the user'} cannot write to {folder['existing']}, for {path}"
            yield problem("disk", member, text, "change its owner, or mount it for writing")


def _sessions(member: CheckedHost) -> Iterator[HostFinding]:
    found = member.facts["max_sessions"]
    if found < MIN_SESSIONS:
        text = f"sshd allows {count(found, 'session')} on a connection (MaxSessions)"
        advice = f"MaxSessions {MIN_SESSIONS} or more in /etc/ssh/sshd_config there"
        yield problem("sessions", member, text, advice)


def _ports(member: CheckedHost) -> Iterator[HostFinding]:
    for kind, error in member.facts["port_errors"].items():
        if kind == "unicast":
            text = f"no UDP port of the domain is free for a node: {error}"
            yield problem(
                "discovery", member, text, "end other nodes, or use another ROS_DOMAIN_ID"
            )
        elif kind == "server":
            text = f"a program has the port of the discovery server already: {error}"
            yield note("discovery", member, text, "end it, or set another `port` of `discovery`")


def _range(member: CheckedHost) -> Iterator[HostFinding]:
    """Settings with which no node of another host is ever found."""
    settings = member.settings
    reach = settings.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")
    peers, name = settings.get("ROS_STATIC_PEERS"), "ROS_AUTOMATIC_DISCOVERY_RANGE"
    if settings.get("ROS_LOCALHOST_ONLY") == "1":
        reach, peers, name = "LOCALHOST", None, "ROS_LOCALHOST_ONLY"
    if settings.get("ROS_DISCOVERY_SERVER"):
        return
    value = settings.get(name, reach)
    if reach == "OFF" or (reach == "LOCALHOST" and not peers):
        text = f"with {name}={value} its nodes find none of other hosts"
        yield problem("discovery", member, text, f"unset {name}, or add --discovery peers")
    elif reach == "SYSTEM_DEFAULT" and peers:
        text = f"with {name}=SYSTEM_DEFAULT, ROS_STATIC_PEERS has no effect"
        yield problem("discovery", member, text, f"{name}=LOCALHOST, or --discovery peers")


_OF_HOSTS: tuple[Judge, ...] = (_engine, _python, _launcher, _packages, _clock, _sessions)
_OF_EVERY: tuple[Judge, ...] = (_folders, _ports, _range)
