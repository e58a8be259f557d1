"""`python -m tests.support.hosts.multicast send ADDRESS...` and `... receive`: what passes.

The receiver joins a group and prints `ready`, then each datagram until `end`. The sender sends
`multicast` to the group, then `end` to each address.
"""

from __future__ import annotations

import socket
import sys

GROUP, PORT = "239.255.0.1", 17400


def receive() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(("", PORT))
        membership = socket.inet_aton(GROUP) + socket.inet_aton("0.0.0.0")
        receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
        print("ready", flush=True)
        text = ""
        while text != "end":
            text = receiver.recv(100).decode()
            print(text, flush=True)


def send(addresses: list[str]) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 8)  # a router may pass it on
        sender.sendto(b"multicast", (GROUP, PORT))
        for address in addresses:
            sender.sendto(b"end", (address, PORT))


if __name__ == "__main__":
    if sys.argv[1] == "send":
        send(sys.argv[2:])
    else:
        receive()
