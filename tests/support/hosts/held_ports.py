"""`python -m tests.support.hosts.held_ports DOMAIN COUNT`: be the first participants of a domain.

Holds the ports that they would have, so that the next one has the number COUNT, from 0.
"""

from __future__ import annotations

import socket
import sys


def main() -> None:
    domain, count = map(int, sys.argv[1:])
    first = 7400 + 250 * domain + 10
    held = []
    for port in range(first, first + 2 * count):
        one = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        one.bind(("", port))
        held.append(one)
    print("held", flush=True)
    sys.stdin.read()


if __name__ == "__main__":
    main()
