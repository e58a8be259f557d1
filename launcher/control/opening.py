"""Opening: makes a run listen, or says why it does not."""

from __future__ import annotations

import functools

from launcher.control.folder import ControlError
from launcher.control.server import Server, socket_path
from launcher.control.service import Identity, Service
from launcher.engine.run_control import RunControl


def open_control(desk: RunControl, identity: Identity) -> Server | None:
    """The server of a run; None, after a warning, where there is no place for its socket."""

    def warn(text: str) -> None:
        desk.chronicle.say("WARNING", "launch", text)

    service = Service(desk, identity)
    try:
        place = functools.partial(socket_path, identity.run_id)
        return Server(
            desk.reactor,
            place(),
            hello=service.hello,
            serve=service.serve,
            warn=warn,
            place=place,
        )
    except ControlError as error:
        warn(f"this run cannot be steered from elsewhere: {error.message}")
        return None
