"""Text files of users, which may be anything: a pipe, a device, gigabytes, a pointer of Git LFS.

A repository has pointers where its large files were not fetched.
"""

from __future__ import annotations

import errno

TYPE_CHECKING = False
if TYPE_CHECKING:
    import os

POINTER = "version https://git-lfs.github.com/spec/"
POINTER_HINT = "to fetch the file itself: git lfs pull, in its repository"
MAX_BYTES = 16 * 1024 * 1024


def read(path: str | os.PathLike[str], *, errors: str = "strict", limit: int = MAX_BYTES) -> str:
    """The text of a file in UTF-8, with "\\n" at the end of each line.

    OSError if it cannot be read or has more than `limit` bytes, ValueError for a path with a NUL,
    UnicodeDecodeError. Of a longer file no more than `limit` bytes are read, so that one without an
    end does not fill the memory.
    """
    text = read_bytes(path, limit=limit).decode("utf-8", errors)
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text


def read_bytes(path: str | os.PathLike[str], *, limit: int = MAX_BYTES) -> bytes:
    """The content of a file; errors as of `read`."""
    with open(path, "rb") as file:
        content = file.read(limit + 1)
    if len(content) > limit:
        raise OSError(errno.EFBIG, f"it has more than {limit >> 20} MiB", str(path))
    return content


def is_pointer(text: str | bytes) -> bool:
    """Whether a file begins like a pointer of Git LFS."""
    return text.startswith(POINTER if isinstance(text, str) else POINTER.encode())  # type: ignore[arg-type]


def pointer_sentence(path: str) -> str:
    return f"{path} is a pointer of Git LFS in place of the file"
