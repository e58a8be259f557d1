"""The variables for discovery of a system and of its probe: of one machine, or of several hosts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from launcher.base.errors import LauncherError

RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"


def of_system(words: Sequence[str]) -> dict[str, str]:
    """For the launcher with these words: nodes of several hosts must see each other."""
    return {RANGE: "LOCALHOST" if _value(words, "--hosts") is None else "SUBNET"}


def of_probe(words: Sequence[str], environment: Mapping[str, str]) -> dict[str, str]:
    """Besides the environment of the launcher: the probe reads the whole graph.

    Empty if the hosts file has mistakes, which the launcher reports.
    """
    path, mode = _value(words, "--hosts"), _value(words, "--discovery")
    if path is None and mode is None:
        return {}
    from launcher.base.model.record import replace
    from launcher.hosts import discovery
    from launcher.hosts.file.hosts_model import Discovery, DiscoveryMode
    from launcher.hosts.file.hosts_reader import read

    try:
        file = None if path is None else read(path, environment, with_secrets=False)
        wanted = Discovery() if file is None else file.discovery
        if mode is not None:
            wanted = replace(wanted, mode=DiscoveryMode(mode))
        hosts = () if file is None else tuple(file.hosts.values())
        domain = environment.get("ROS_DOMAIN_ID", "")
        return discovery.wire(wanted, hosts, domain=domain).graph_environment()
    except (LauncherError, ValueError):
        return {}


def _value(words: Sequence[str], option: str) -> str | None:
    """The value of an option that is given at most once."""
    for place, word in enumerate(words):
        name, sign, value = word.partition("=")
        if name == option:
            return value if sign else next(iter(words[place + 1 :]), None)
    return None
