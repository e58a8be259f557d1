"""Requests to an agent as payloads of frames."""

from __future__ import annotations

import zlib

from launcher.hosts.engine.frames import OUTPUT_HEADER, pack
from launcher.hosts.file.order import Order


def key_of(run_id: str, host: str) -> str:
    """Names an agent on its host, among those of other runs."""
    return f"{run_id}-{zlib.crc32(host.encode()):08x}"


def prepare(process_id: int, order: Order) -> bytes:
    from launcher.hosts.file import order_json

    return pack({"id": process_id, "order": order_json.encode(order)})


def stdin(process_id: int, data: bytes) -> bytes:
    return OUTPUT_HEADER.pack(process_id, 0) + data
