"""Compression by rosbag2: of whole files, or of each message, by zstd."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Callable, Iterator
from typing import IO

from launcher.bag.bag_model import BagError, one_line

FORMATS = ("zstd",)
MODES = ("none", "file", "message")
PRESETS = {"none": "none", "fastwrite": "none", "zstd_fast": "zstd", "zstd_small": "zstd_small"}
_PIECE = 1 << 20
# Pieces up to this size, or up to so many times their compressed size, are believed to be so large.
_USUAL_BYTES, _USUAL_RATIO = 128 * _PIECE, 1000


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
        sink = stack.enter_context(tempfile.NamedTemporaryFile(prefix="launcher-"))
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

    def decompress(data: bytes) -> bytes:
        try:
            size = zstandard.frame_content_size(data)
            if size >= 0:
                return exactly(data, size, "zstd")
            return _read(_zstd_pieces(data), _most_of(data))  # the size is not in the frame
        except (zstandard.ZstdError, ValueError) as error:
            raise ValueError(f"a compressed message is damaged: {one_line(error)}") from None

    return decompress


def exactly(data: bytes, size: int, format_name: str) -> bytes:
    """Decompress `size` bytes; `format_name` is that of a chunk of MCAP, empty for none.

    ValueError if the data are damaged, or not of this size: what is beyond is never decompressed.
    """
    if format_name == "":
        found = data
    elif format_name not in _PIECES:
        raise ValueError(f"its compression {format_name[:20]!r} is unknown")
    elif size > _most_of(data):
        raise ValueError(f"it would have {size} bytes, compressed to {len(data)}")
    else:
        try:
            found = _at_once(data, size) if format_name == "zstd" else b""
            found = found or _read(_PIECES[format_name](data), size)
        except (RuntimeError, EOFError, MemoryError) as error:  # of lz4
            raise ValueError(one_line(error)) from None
    if len(found) != size:
        raise ValueError(f"it has {len(found)} bytes, and says {size}")
    return found


def _at_once(data: bytes, size: int) -> bytes:
    """One frame of zstd that says this size; nothing of another one, or of several."""
    import zstandard

    with contextlib.suppress(zstandard.ZstdError):
        if size and zstandard.frame_content_size(data) == size:
            return bytes(zstandard.ZstdDecompressor().decompress(data, allow_extra_data=False))
    return b""


def _most_of(data: bytes) -> int:
    return max(_USUAL_BYTES, _USUAL_RATIO * len(data))


def _read(pieces: Iterator[bytes], most: int) -> bytes:
    """All pieces; ValueError if they are more than `most` bytes."""
    found, size = [], 0
    for piece in pieces:
        size += len(piece)
        if size > most:
            raise ValueError(f"it has more than {most} bytes")
        found.append(piece)
    return found[0] if len(found) == 1 else b"".join(found)


def _zstd_pieces(data: bytes) -> Iterator[bytes]:
    import zstandard

    try:
        with zstandard.ZstdDecompressor().stream_reader(data, read_across_frames=True) as stream:
            while piece := stream.read(_PIECE):
                yield piece
    except zstandard.ZstdError as error:
        raise ValueError(one_line(error)) from None


def _lz4_pieces(data: bytes) -> Iterator[bytes]:
    from lz4.frame import LZ4FrameDecompressor

    decompressor = LZ4FrameDecompressor()
    piece = decompressor.decompress(data, max_length=_PIECE)
    while piece or not decompressor.eof:
        yield piece
        if decompressor.eof:
            return
        if decompressor.needs_input:
            raise ValueError("its data end too early")
        piece = decompressor.decompress(b"", max_length=_PIECE)


_PIECES = {"zstd": _zstd_pieces, "lz4": _lz4_pieces}
