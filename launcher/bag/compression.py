"""Compression by rosbag2: of whole files, or of each message, by zstd."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Callable
from typing import IO

from launcher.bag.errors import BagError

FORMATS = ("zstd",)
MODES = ("none", "file", "message")


def check_format(name: str) -> None:
    """BagError for a format that is not zstd, the only one that comes with rosbag2."""
    if name and name not in FORMATS:
        raise BagError(f"compression '{name}' is not supported", hint="rosbag2 itself has zstd")


def compress_file(path: str, suffix: str = "zstd") -> str:
    """Replace a file by a compressed one; its path. OSError, and then the file is as before."""
    import zstandard

    target = f"{path}.{suffix}"
    try:
        with open(path, "rb") as source, open(f"{target}.tmp", "wb") as sink:
            zstandard.ZstdCompressor().copy_stream(source, sink)
            sink.flush()
            os.fsync(sink.fileno())
    except BaseException:
        if os.path.exists(f"{target}.tmp"):
            os.unlink(f"{target}.tmp")
        raise
    os.replace(f"{target}.tmp", target)
    os.unlink(path)
    return target


def decompressed(path: str) -> IO[bytes]:
    """The contents of a compressed file, in a temporary file until it is closed.

    BagError, OSError.
    """
    import zstandard

    with contextlib.ExitStack() as stack:
        sink = stack.enter_context(tempfile.NamedTemporaryFile())
        with open(path, "rb") as source:
            try:
                zstandard.ZstdDecompressor().copy_stream(source, sink)
            except zstandard.ZstdError as error:
                raise BagError(f"cannot decompress {path}: {error}") from None
        sink.seek(0)
        stack.pop_all()
    return sink


def is_compressed(data: bytes) -> bool:
    """Whether a message is; CDR begins with a zero."""
    return data.startswith(b"\x28\xb5\x2f\xfd")


def message_compressor() -> Callable[[bytes], bytes]:
    import zstandard

    return zstandard.ZstdCompressor().compress


def message_decompressor() -> Callable[[bytes], bytes]:
    """Decompresses a message; ValueError if it is damaged."""
    import zstandard

    decompressor = zstandard.ZstdDecompressor()

    def decompress(data: bytes) -> bytes:
        try:
            if zstandard.frame_content_size(data) >= 0:
                return decompressor.decompress(data)
            return decompressor.decompressobj().decompress(data)  # the size is not in the frame
        except zstandard.ZstdError as error:
            raise ValueError(f"a compressed message is damaged: {error}") from None

    return decompress
