"""The control protocol: one JSON object per line (docs/reference/control.md)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from launcher.base import strict_json
from launcher.base.model.record import Record
from launcher.base.run_verb import BadCallError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

VERSION = 2
# Settings that decide which participants discover each other, besides the domain.
DISCOVERY_VARIABLES = (
    "RMW_IMPLEMENTATION",
    "ROS_AUTOMATIC_DISCOVERY_RANGE",
    "ROS_LOCALHOST_ONLY",
    "ROS_STATIC_PEERS",
    "ROS_DISCOVERY_SERVER",
    "ROS_SECURITY_ENABLE",
    "FASTDDS_BUILTIN_TRANSPORTS",
    "FASTRTPS_DEFAULT_PROFILES_FILE",
    "FASTDDS_DEFAULT_PROFILES_FILE",
    "CYCLONEDDS_URI",
)
REQUEST_LIMIT = 64 * 1024  # bytes of a request with its newline


def node_variables(run: Mapping[str, Any]) -> dict[str, str]:
    """The variables with which the nodes of a run are found; `run` is that of its first line."""
    found = dict(run.get("discovery") or {})
    if run.get("domain_id") is not None:
        found["ROS_DOMAIN_ID"] = str(run["domain_id"])
    return found


class Request(Record):
    """A request; every answer to it repeats its `id`."""

    id: object
    verb: str
    names: tuple[str, ...]
    options: Mapping[str, Any]

    def line(self) -> bytes:
        """As it is sent."""
        document = {"protocol": VERSION, "id": self.id, "verb": self.verb}
        document |= {"names": list(self.names), "options": dict(self.options)}
        return strict_json.packed(document).encode() + b"\n"


class RequestError(Exception):
    """A line that is not a request; `id` is the one it gave, if it could be read."""

    def __init__(self, cause: BadCallError, request_id: object = None) -> None:
        super().__init__(cause.message)
        self.cause = cause
        self.id = request_id


def parse_request(line: bytes) -> Request:
    """Raises RequestError."""
    try:
        document = strict_json.loads(line)
    except ValueError:
        raise _bad("a request is one JSON object on a line, in UTF-8") from None
    if not isinstance(document, dict):
        raise _bad("a request is a JSON object")
    request_id = document.get("id")
    if isinstance(request_id, (dict, list)):
        raise _bad("'id' is a number, a text or null")
    version = document.get("protocol", VERSION)
    if isinstance(version, bool) or version != VERSION:
        cause = BadCallError(
            "version",
            f"unsupported protocol {strict_json.dumps(version)[:20]}: this run uses {VERSION}",
            "use the launcher that started the run; its version is in the first line it sends",
        )
        raise RequestError(cause, request_id)
    return _request(document, request_id)


def _request(document: dict[str, Any], request_id: object) -> Request:
    verb = document.get("verb")
    names = document.get("names") or []
    options = document.get("options") or {}
    if not isinstance(verb, str):
        raise _bad("'verb' is a text", request_id)
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise _bad("'names' is a list of texts", request_id)
    if not isinstance(options, dict):
        raise _bad("'options' is an object", request_id)
    return Request(request_id, verb, tuple(names), options)


def _bad(message: str, request_id: object = None) -> RequestError:
    return RequestError(BadCallError("bad-request", message), request_id)


# ---- answers


def encode(document: Mapping[str, Any]) -> bytes:
    return to_json(document).encode() + b"\n"


def to_json(document: Mapping[str, Any]) -> str:
    return strict_json.dumps(document, separators=(",", ":"), default=str)


def reply(request_id: object, result: Mapping[str, Any], text: Sequence[str]) -> bytes:
    """The last answer to a request that succeeded."""
    return encode({"id": request_id, "ok": True, "result": result, "text": list(text)})


def raw_item(request_id: object, text: str) -> bytes:
    """An item of a stream that is JSON already."""
    return f'{{"id":{strict_json.dumps(request_id)},"item":{text}}}\n'.encode()


def raw_reply(request_id: object, name: str, values: Sequence[str]) -> bytes:
    """Values that are JSON already, as the result and as the text."""
    number, text = strict_json.dumps(request_id), strict_json.dumps(list(values))
    result = f'{{"{name}":[{",".join(values)}]}}'
    return f'{{"id":{number},"ok":true,"result":{result},"text":{text}}}\n'.encode()


def failure(request_id: object, problem: BadCallError) -> bytes:
    """The last answer to a request that failed."""
    return encode({"id": request_id, "ok": False, "error": problem.document})
