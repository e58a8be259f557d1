"""Makes messages of bytes; a KeyboardInterrupt meanwhile stays one.

rclpy runs Python to fill a message, and a handler of signals may raise there. It loses that: it
raises another error instead (docs/inside/ros2-behaviour.md, 4.24).
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from typing import Any


def decoder(kind: Any) -> Callable[[bytes], Any]:
    """A function from serialized messages to those of a class.

    It raises RMWError for bytes that are no such message, and the KeyboardInterrupt of a handler.
    """
    from rclpy.serialization import deserialize_message

    def decode(data: bytes) -> Any:
        try:
            return deserialize_message(data, kind)
        except TypeError as error:  # not `kept_interrupts`, which takes as long as a small message
            if isinstance(error.__cause__, KeyboardInterrupt):
                raise KeyboardInterrupt from None
            raise

    return decode


@contextlib.contextmanager
def kept_interrupts() -> Iterator[None]:
    """Raise the KeyboardInterrupt of which rclpy has made another error.

    For requests and answers of services. Of messages that an executor takes it leaves no trace:
    take them as bytes.
    """
    try:
        yield
    except SystemError as error:
        if isinstance(error.__cause__, KeyboardInterrupt):
            raise KeyboardInterrupt from None
        raise
