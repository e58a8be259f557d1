"""What no protocol takes for a request: an error that the client is sent, whatever it was."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from launcher.base.ros_errors import VerbError
from launcher.control.protocol import RequestError, parse_request
from launcher.hosts.engine.frames import Frame, FrameError, FrameKind
from launcher.ros.foxglove.protocol import ProtocolError, parse_text
from launcher.ros.probe.protocol import ProbeRequest

Parse = Callable[[str], Any]
PARSERS: dict[str, tuple[Parse, type[Exception]]] = {
    "control socket": (lambda text: parse_request(text.encode()), RequestError),
    "probe": (lambda text: ProbeRequest(text.encode()), VerbError),
    "foxglove": (parse_text, ProtocolError),
}
ODD = {
    "deep list": "[" * 100_000,
    "deep object": '{"a":' * 100_000,
    "deep and closed": '{"op": "a", "verb": "ps", "id": ' + "[" * 300 + "]" * 300 + "}",
    "infinite": '{"op": "a", "verb": "ps", "id": 1e999}',
    "minus infinite": '{"op": "a", "verb": "ps", "id": -1e999}',
    "nan": '{"op": "a", "verb": "ps", "id": NaN}',
    "long number": '{"op": "a", "verb": "ps", "id": ' + "1" * 5000 + "}",
    "large number": '{"op": "a", "verb": "ps", "id": ' + "1" * 400 + "}",
    "list": "[1]",
    "nothing": "",
}
ANY_ODD = pytest.mark.parametrize("text", ODD.values(), ids=ODD)


@ANY_ODD
@pytest.mark.parametrize(("parse", "error"), PARSERS.values(), ids=PARSERS)
def test_what_is_no_request_is_refused(parse: Parse, error: type[Exception], text: str):
    with pytest.raises(error):
        parse(text)


@pytest.mark.parametrize("name", ["deep list", "deep object", "long number", "list", "nothing"])
def test_a_frame_of_a_host_is_no_object(name: str):
    with pytest.raises(FrameError):
        Frame(FrameKind.OPEN, 0, 0.0, ODD[name].encode()).content()
