"""What the server of the page is told: as options of a verb, or as JSON by the launcher."""

from __future__ import annotations

import dataclasses
from typing import Any

from launcher.base import strict_json

DEFAULT_HOST = "127.0.0.1"
DEFAULT_PORT = 8770


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class PageSettings:
    """`socket`: of the run. `port` None: the default one, or any if that is taken. The token is
    that of `token_file`, `token`, or a new one. `certificate` and `key` are files in PEM."""

    socket: str
    host: str = DEFAULT_HOST
    port: int | None = None
    token_file: str | None = None
    token: str | None = None
    certificate: str | None = None
    key: str | None = None
    read_only: bool = False

    @classmethod
    def from_json(cls, text: str) -> PageSettings:
        values: dict[str, Any] = strict_json.unpacked(text)
        return cls(**values)
