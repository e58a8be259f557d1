"""What a client is sent that does not read."""

from __future__ import annotations

import json
import socket

from launcher.control.peer import OUTPUT_LIMIT, Exchange, Peer
from launcher.control.protocol import Request
from launcher.posix.reactor import Reactor


def test_a_report_of_items_left_out_that_is_dropped_counts_for_all_of_them():
    ours, theirs = socket.socketpair()
    exchanges: list[Exchange] = []

    def serve(request: Request, exchange: Exchange) -> None:
        exchange.is_stream = True
        exchanges.append(exchange)

    with Reactor() as reactor, theirs:
        Peer(reactor, ours, serve=serve, on_close=lambda peer: None)
        theirs.sendall(b'{"verb": "logs", "id": 1, "options": {"follow": true}}\n')
        while not exchanges:
            reactor._turn(1.0)
        (exchange,) = exchanges
        while exchange.dropped == 0:
            exchange.item({"text": "x" * 10_000})
        exchange.item({"dropped": 500}, stands_for=500)
        exchange.reply({"ended": True})
        theirs.settimeout(1.0)
        received = b""
        while b'"ended"' not in received:
            reactor._turn(0.0)
            received += theirs.recv(OUTPUT_LIMIT)
    items = [json.loads(line).get("item", {}) for line in received.splitlines()]
    assert [one["dropped"] for one in items if "dropped" in one] == [501]
