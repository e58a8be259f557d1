"""Texts of manifests as Kubernetes has to read them, so that nothing in them is replaced."""

from __future__ import annotations

import re
from collections.abc import Container

_OF_CLUSTER = "KUBERNETES_"  # variables with the address of the cluster, which every pod gets
# What Kubernetes reads at a dollar: an escaped one, or the name of a variable up to the bracket.
_READ = re.compile(r"\$\$|\$\(([^)]*)\)")


def literal(text: str, known: Container[str]) -> str:
    """The text for a place where the variables `known` would be replaced.

    Only what Kubernetes would change is escaped, since `podman kube play` replaces nothing and
    removes no escape: `$(date)` stays, where there is no variable `date`.
    """

    def escaped(found: re.Match[str]) -> str:
        name = found[1]
        if name is None:
            return "$$$$"
        is_variable = name in known or name.startswith(_OF_CLUSTER)
        return f"${found[0]}" if is_variable else found[0]

    return _READ.sub(escaped, text)
