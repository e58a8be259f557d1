"""The launcher with loopback links: `python -m tests.support.loopback.run WORDS`.

With SWITCHES in the environment, a FIFO, it obeys lines such as `cut bot1`, `restore bot1` and
`power_off bot1`.
"""

from __future__ import annotations

import os
import sys

from launcher.__main__ import main
from launcher.hosts.engine import host_links
from launcher.hosts.engine.link import LinkContext
from tests.support.loopback.link import LoopbackLink

SWITCHES = "LOOPBACK_SWITCHES"
links: dict[str, LoopbackLink] = {}


def make_link(context: LinkContext) -> LoopbackLink:
    link = links[context.host.name] = LoopbackLink(context)
    if len(links) == 1 and SWITCHES in os.environ:
        fifo = os.open(os.environ[SWITCHES], os.O_RDWR | os.O_NONBLOCK | os.O_CLOEXEC)
        context.reactor.add_reader(fifo, lambda: obey(os.read(fifo, 4096).decode()))
    return link


def obey(text: str) -> None:
    for line in text.splitlines():
        switch, name = line.split()
        getattr(links[name], switch)()


if __name__ == "__main__":
    host_links.make_link = make_link
    sys.exit(main())
