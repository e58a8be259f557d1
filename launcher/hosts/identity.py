"""What launchers on two hosts compare: their code, and the protocol of `hosts/engine/frames`."""

from __future__ import annotations

import os

PROTOCOL = 1  # another one on the other side is an error


def code_id() -> str:
    """The same for launchers with the same sources, which may have the same version number."""
    import hashlib

    import launcher

    root = os.path.dirname(os.path.abspath(launcher.__file__ or ""))
    sha = hashlib.sha256()
    for folder, below, names in os.walk(root):
        below.sort()
        for name in sorted(names):
            if name.endswith(".py"):
                path = os.path.join(folder, name)
                with open(path, "rb") as file:
                    content = hashlib.sha256(file.read()).digest()
                sha.update(os.fsencode(os.path.relpath(path, root)) + b"\0" + content)
    return sha.hexdigest()[:12]
