"""The writer of YAML: what is read back is what was written."""

from __future__ import annotations

from typing import Any

import yaml

_LINE_BREAKS = frozenset("\x85\u2028\u2029")  # for YAML; PyYAML loses the first between quotes


class Dumper(yaml.SafeDumper):
    """Writes repeated values out instead of aliases, and escapes rare line breaks."""

    def ignore_aliases(self, data: object) -> bool:
        return True

    def analyze_scalar(self, scalar: str) -> Any:
        analysis = super().analyze_scalar(scalar)
        if not _LINE_BREAKS.isdisjoint(scalar):
            analysis.allow_flow_plain = analysis.allow_block_plain = False
            analysis.allow_single_quoted = analysis.allow_block = False
        return analysis
