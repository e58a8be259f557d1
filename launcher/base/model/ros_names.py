"""Names of topics, services, actions and nodes."""

from __future__ import annotations


def full_name(name: str) -> str:
    """The name with its leading slash, without which it may be given; an empty one stays empty."""
    return f"/{name}" if name and not name.startswith("/") else name
