"""Output configurations: what `output=` of a process means."""

from __future__ import annotations

from collections.abc import Mapping

from launcher.base.model.spec import OutputPolicy, Sink

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

_SINKS = {"screen": Sink.SCREEN, "log": Sink.LOG, "own_log": Sink.OWN_LOG}


def output_policy(output: str | Mapping[str, Any]) -> OutputPolicy:
    """The sinks of a value of `output=`; ValueError for an unknown word."""
    if isinstance(output, str):
        return OutputPolicy.named(output)
    unknown = [key for key in output if key not in ("stdout", "stderr", "both")]
    if unknown:
        raise ValueError(
            f"{unknown} are not valid output destinations; expected stdout, stderr or both"
        )
    both = _sinks(output.get("both", ()))
    return OutputPolicy(
        stdout=_sinks(output.get("stdout", ())) | (both & ~Sink.OWN_LOG),
        stderr=_sinks(output.get("stderr", ())) | (both & ~Sink.OWN_LOG),
        combined=both & Sink.OWN_LOG,
    )


def _sinks(words: Any) -> Sink:
    sinks = Sink.NONE
    for word in [words] if isinstance(words, str) else words:
        if word not in _SINKS:
            raise ValueError(
                f"{word} is not a valid logging destination; expected screen, log or own_log"
            )
        sinks |= _SINKS[word]
    return sinks
