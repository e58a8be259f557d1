"""Pointer files of Git LFS, which a repository has where its large files were not fetched."""

from __future__ import annotations

POINTER = "version https://git-lfs.github.com/spec/"
HINT = "to fetch the file itself: git lfs pull, in its repository"


def is_pointer(text: str | bytes) -> bool:
    """Whether a file begins like a pointer."""
    return text.startswith(POINTER if isinstance(text, str) else POINTER.encode())  # type: ignore[arg-type]


def sentence(path: str) -> str:
    return f"{path} is a pointer of Git LFS in place of the file"
