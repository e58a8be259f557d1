"""Takes serialized messages and says who published each, which rclpy does not.

rclpy's `take_message` copies a message twice and drops the id of its publisher. This calls the same
function of rcl, `rcl_take_serialized_message`, whose structures are the same in the headers of
Jazzy and Kilted (`rmw/types.h`, `rcutils/types/uint8_array.h`).
"""

from __future__ import annotations

import ctypes
import functools
import os
from ctypes import POINTER, byref, c_bool, c_char_p, c_int64, c_size_t, c_uint8, c_uint64, c_void_p
from typing import TYPE_CHECKING, Any, NamedTuple

from launcher.posix import proc

if TYPE_CHECKING:
    from rclpy.node import Node
    from rclpy.subscription import Subscription

_INITIAL_BYTES = 64 * 1024
_TAKE_FAILED = 401  # RCL_RET_SUBSCRIPTION_TAKE_FAILED: there is no message
_GID_BYTES = 16  # RMW_GID_STORAGE_SIZE


class RawMessage(NamedTuple):
    """A serialized message; times are wall clock nanoseconds, `publisher` is its 16-byte gid.

    `sequence` counts the messages of the publisher, from 1.
    """

    data: bytes
    publisher: bytes
    sequence: int
    source_ns: int
    received_ns: int


def subscribed(node: Node, kind: object, topic: str, profile: object) -> Any:
    """A subscription whose messages are taken: no executor ever calls its callback."""
    return node.create_subscription(kind, topic, lambda message: None, profile, raw=True)


class _Allocator(ctypes.Structure):
    _fields_ = [
        ("allocate", c_void_p),
        ("deallocate", c_void_p),
        ("reallocate", c_void_p),
        ("zero_allocate", c_void_p),
        ("state", c_void_p),
    ]


class _Array(ctypes.Structure):
    _fields_ = [
        ("buffer", c_void_p),
        ("length", c_size_t),
        ("capacity", c_size_t),
        ("allocator", _Allocator),
    ]


class _Info(ctypes.Structure):
    _fields_ = [
        ("source_ns", c_int64),
        ("received_ns", c_int64),
        ("publication_sequence", c_uint64),
        ("reception_sequence", c_uint64),
        ("implementation", c_char_p),
        ("publisher", c_uint8 * _GID_BYTES),
        ("from_intra_process", c_bool),
    ]


class RawTaker:
    """Takes the messages of a subscription of rclpy; RuntimeError if rcl fails."""

    def __init__(self) -> None:
        self._rcl, self._rcutils = _libraries()
        self._array = _Array()
        self._info = _Info()
        allocator = self._rcutils.rcutils_get_default_allocator()
        self._rcutils.rcutils_uint8_array_init(byref(self._array), _INITIAL_BYTES, byref(allocator))
        self._array_ref, self._info_ref = byref(self._array), byref(self._info)

    def take(self, subscription: Subscription) -> RawMessage | None:
        """The next message of `rclpy`'s handle, which the caller keeps alive; None without one."""
        pointer = subscription.pointer
        code = self._rcl.rcl_take_serialized_message(pointer, self._array_ref, self._info_ref, None)
        if code == _TAKE_FAILED:
            return None
        if code != 0:
            raise RuntimeError(f"rcl_take_serialized_message returned {code}")
        array, info = self._array, self._info
        return RawMessage(
            ctypes.string_at(array.buffer, array.length),
            bytes(info.publisher),
            info.publication_sequence,
            info.source_ns,
            info.received_ns,
        )

    def close(self) -> None:
        self._rcutils.rcutils_uint8_array_fini(self._array_ref)


@functools.cache
def _libraries() -> tuple[Any, Any]:
    """librcl and librcutils as rclpy has loaded them."""
    rcl, rcutils = ctypes.CDLL(_loaded("librcl.so")), ctypes.CDLL(_loaded("librcutils.so"))
    take = rcl.rcl_take_serialized_message
    take.argtypes = [c_void_p, POINTER(_Array), POINTER(_Info), c_void_p]
    rcutils.rcutils_get_default_allocator.restype = _Allocator
    rcutils.rcutils_uint8_array_init.argtypes = [POINTER(_Array), c_size_t, POINTER(_Allocator)]
    rcutils.rcutils_uint8_array_fini.argtypes = [POINTER(_Array)]
    return rcl, rcutils


def _loaded(name: str) -> str:
    for path in proc.mapped(os.getpid()):
        if path.endswith(f"/{name}"):
            return path
    raise RuntimeError(f"rclpy has not loaded {name}")
