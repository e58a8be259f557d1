"""Cutting: texts that are too long for their place, with a mark where something is missing."""

from __future__ import annotations

from rich.cells import cell_len, set_cell_size

MARK = "…"


def end_cut(text: str, columns: int) -> str:
    """The beginning of the text."""
    return text if cell_len(text) <= columns else set_cell_size(text, max(0, columns - 1)) + MARK


def middle_cut(text: str, columns: int) -> str:
    """Its beginning and its end, which tells names that begin alike apart."""
    if cell_len(text) <= columns:
        return text
    end = _end(text, (columns - 1) // 2)
    return set_cell_size(text, max(0, columns - 1 - cell_len(end))).rstrip() + MARK + end


def _end(text: str, columns: int) -> str:
    """As much of the end of the text as has room."""
    start = len(text)
    while start > 0 and cell_len(text[start - 1 :]) <= columns:
        start -= 1
    return text[start:]
