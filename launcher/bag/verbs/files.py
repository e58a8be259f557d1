"""The options of the files that `bag record` and `bag convert` write."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import TYPE_CHECKING

from launcher.bag.compression import FORMATS, MODES, PRESETS
from launcher.base.command_line import Parsed
from launcher.base.option import Option, count, option, seconds

if TYPE_CHECKING:
    from launcher.bag.writer import Storage

MAX = 2**63 - 1
STORAGES = ("mcap", "sqlite3")


def byte_count(word: str) -> int:
    """A number of bytes, with `k`, `M` or `G` behind it (powers of 1024)."""
    units = {"k": 1024, "K": 1024, "M": 1024**2, "G": 1024**3}
    number, factor = (word[:-1], units[word[-1]]) if word[-1:] in units else (word, 1)
    return count(number, 0, MAX // factor) * factor


INPUT = option("-i, --input URI ...", "bags as well, as in ros2: -i BAG [STORAGE]", repeat="all")


def inputs(options: Parsed) -> Iterator[str]:
    """The bags of `INPUT`; the files show their format."""
    for path, *others in options.input or ():
        yield path
        yield from (one for one in others if one not in STORAGES or os.path.exists(one))


SPLIT = (
    option(
        "-b, --max-bag-size BYTES",
        "begin a new file after so many bytes (k, M or G may follow); 0 is never",
        byte_count,
        0,
    ),
    option(
        "-d, --max-bag-duration S", "begin a new file after S seconds; 0 is never", seconds, 0.0
    ),
)
COMPRESSION = (
    option(
        "--compression-mode MODE",
        "compress each message or whole files, besides the chunks",
        choices=MODES,
        default="none",
    ),
    option("--compression-format FORMAT", "format of --compression-mode", choices=FORMATS),
    option(
        "--storage-preset-profile NAME",
        "none and fastwrite: no compression of chunks",
        choices=tuple(PRESETS),
        default="zstd_fast",
    ),
)


def ignored(*spellings: str) -> tuple[Option, ...]:
    """Options of ros2 for which there is nothing to do here."""
    return tuple(option(one, "ignored, for compatibility with ros2") for one in spellings)


def storage_of(options: Parsed) -> Storage:
    from launcher.bag.writer import Storage

    return Storage(
        chunk_compression=PRESETS[options.storage_preset_profile],
        mode=options.compression_mode,
        format=options.compression_format or FORMATS[0],
        max_bytes=options.max_bag_size,
        max_duration_ns=round(options.max_bag_duration * 1e9),
        max_files=getattr(options, "max_bag_files", 0),
    )
