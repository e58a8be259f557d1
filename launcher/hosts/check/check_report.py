"""The result of a check for people, and for programs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from launcher.base.model.level import Level
from launcher.base.text import aligned, count, escape
from launcher.hosts.check.examine import Examination
from launcher.hosts.check.host_findings import CheckedHost, HostFinding
from launcher.hosts.check.host_judges import MB, duration, engine_of
from launcher.hosts.check.pair_judges import distro_of, domain_of, middleware_of
from launcher.hosts.file.hosts_model import HostEngine

_HEAD = (
    "host",
    "login",
    "user",
    "engine",
    "python",
    "launcher",
    "plan",
    "clock",
    "ros",
    "free",
    "discovery",
)
_NOTHING = "-"


def as_text(result: Examination) -> str:
    """A table with a row for each host; below it what is wrong, with its repair."""
    rows = [_HEAD, *(_row(result, one) for one in result.survey.members.values())]
    lines = aligned(rows)
    for finding in result.findings:
        names = ", ".join(finding.hosts)
        lines.append("")
        lines.append(f"{finding.level.value}: {names}: {finding.text}")
        lines.append(f"  -> {finding.advice}")
    lines += ["", _last_line(result)]
    return escape("\n".join(lines))


def _last_line(result: Examination) -> str:
    hosts = list(result.survey.hosts)
    problems = sum(one.level is Level.PROBLEM for one in result.findings)
    if not problems:
        return f"{count(len(hosts), 'host')}: no problem"
    return f"{count(len(hosts), 'host')}: {count(problems, 'problem')}"


def _row(result: Examination, member: CheckedHost) -> tuple[str, ...]:
    if not member.facts:
        login = "no" if member.reached_s is None else duration(member.reached_s)
        return (member.name, login, member.user or _NOTHING, *[_NOTHING] * (len(_HEAD) - 3))
    facts = member.facts
    is_host = member.host is not None
    return (
        member.name,
        duration(member.reached_s) if member.reached_s is not None else _NOTHING,
        member.user or _NOTHING,
        _engine(member) if is_host else _NOTHING,
        ".".join(map(str, facts["python"])),
        str(facts["version"] or "none"),
        _plan(member),
        _clock(member),
        _ros(member),
        _free(member),
        _discovery(result, member),
    )


def _engine(member: CheckedHost) -> str:
    engine = engine_of(member)
    if engine is not HostEngine.SYSTEMD:
        return str(engine.value)
    version = member.facts["systemd"]
    return f"systemd {version}" if version else "no systemd"


def _plan(member: CheckedHost) -> str:
    if not member.needs.count or member.facts["version"] is None:
        return _NOTHING
    missing = sum(len(names) for names in member.facts["missing"].values())
    return "all found" if not missing else f"{missing} missing"


def _clock(member: CheckedHost) -> str:
    clock = member.clock
    if clock is None or member.host is None:
        return _NOTHING
    sign = "+" if clock.offset_s >= 0 else "-"
    return f"{sign}{duration(abs(clock.offset_s))} ± {duration(clock.uncertainty_s)}"


def _ros(member: CheckedHost) -> str:
    middleware = middleware_of(member).removeprefix("rmw_").removesuffix("_cpp")
    return f"{distro_of(member) or 'none'}, {middleware}, domain {domain_of(member)}"


def _free(member: CheckedHost) -> str:
    """The least of the folders; memory is not space on a disk."""
    found = [one for one in member.facts["folders"] if "free" in one]
    disks = [one["free"] for one in found if one["path"] != "/dev/shm"]
    return _size(min(disks)) if disks else _NOTHING


def _size(found: int) -> str:
    return f"{found / MB / 1024:.0f} GiB" if found >= 10240 * MB else f"{found / MB:.0f} MiB"


def _discovery(result: Examination, member: CheckedHost) -> str:
    """With how many of the others something gets through in both directions."""
    others = len(result.survey.reached) - 1
    words = []
    for kind in ("unicast", "multicast"):
        pairs = [pair for pair in result.survey.lost(kind) if member.name in pair]
        cut = {name for pair in pairs for name in pair} - {member.name}
        words.append(f"{kind} {others - len(cut)}/{others}")
    return ", ".join(words) if others else _NOTHING


# ---- for programs


def as_document(result: Examination) -> dict[str, Any]:
    """`well` is whether there is no problem."""
    return {
        "well": result.is_well,
        "discovery": None if result.mode is None else result.mode.value,
        "hosts": [{"name": name, **_member(one)} for name, one in result.survey.members.items()],
        "network": {
            kind: [list(pair) for pair in result.survey.lost(kind)]
            for kind in ("unicast", "multicast")
        },
        "findings": _findings(result.findings),
    }


def _folder(facts: Mapping[str, Any]) -> dict[str, Any]:
    """With units, which the facts of the probe do not name."""
    units = {"total": "total_bytes", "free": "free_bytes"}
    return {units.get(key, key): value for key, value in facts.items()}


def _findings(findings: Sequence[HostFinding]) -> list[dict[str, Any]]:
    return [
        {
            "check": one.check,
            "hosts": list(one.hosts),
            "level": one.level.value,
            "text": one.text,
            "advice": one.advice,
        }
        for one in findings
    ]


def _member(member: CheckedHost) -> dict[str, Any]:
    found: dict[str, Any] = {
        "address": member.address,
        "reached": bool(member.facts),
        "login_s": member.reached_s,
        "user": member.user or None,
        "error": None if member.error is None else member.error.message,
    }
    if not member.facts:
        return found
    facts = member.facts
    clock = member.clock
    return {
        **found,
        "engine": None if member.host is None else engine_of(member).value,
        "systemd": facts["systemd"],
        "python": ".".join(map(str, facts["python"])),
        "launcher": facts["version"],
        "missing": facts["missing"],
        "clock_offset_s": None if clock is None else clock.offset_s,
        "clock_uncertainty_s": None if clock is None else clock.uncertainty_s,
        "ros_distro": distro_of(member),
        "middleware": middleware_of(member),
        "domain_id": domain_of(member),
        "folders": [_folder(one) for one in facts["folders"]],
        "max_sessions": facts["max_sessions"],
        "addresses": facts["addresses"],
    }
