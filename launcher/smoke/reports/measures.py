"""The measured numbers of a run, and the baseline file to compare them with."""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from launcher.base import strict_json, text_file
from launcher.base.document.source_location import Origin
from launcher.base.errors import UsageError
from launcher.smoke.expect.expectation import Decision, Expectation, Verdict
from launcher.smoke.observe.facts import label_of
from launcher.smoke.reports.artifacts import save
from launcher.smoke.reports.result import Judged, SmokeResult

VERSION = 1
_MB = 1024 * 1024


@dataclass(frozen=True, slots=True)
class Measure:
    """A number with its unit; `kind` decides its tolerance."""

    name: str
    kind: str
    value: float
    unit: str


@dataclass(frozen=True, slots=True)
class Tolerance:
    """How much a value may exceed the baseline, in percent and at least by `least`.

    `both`: it may also fall below the baseline only by so much.
    """

    percent: float
    least: float = 0.0
    both: bool = False

    def limits(self, base: float) -> tuple[float, float]:
        """(lowest, highest) value without a regression."""
        room = max(abs(base) * self.percent / 100, self.least)
        return (base - room if self.both else float("-inf"), base + room)


# A start takes longer on a busy machine, and the first megabytes differ with the allocator.
TOLERANCES = {
    "rate": Tolerance(percent=20, both=True),
    "start_up": Tolerance(percent=50, least=1.0),
    "cpu": Tolerance(percent=50, least=10.0),
    "memory": Tolerance(percent=25, least=20.0),
}


def of_result(result: SmokeResult) -> list[Measure]:
    facts = result.facts
    found = [
        Measure(one.expectation.name, "rate", one.verdict.value, "Hz")
        for one in result.judged
        if one.expectation.kind == "rate" and one.verdict.value is not None
    ]
    if facts.ready_s is not None:
        found.append(Measure("start_up", "start_up", facts.ready_s, "s"))
    for name in facts.processes():
        label = label_of(name)
        samples = [s for s in facts.samples if s.process == name and s.at_s <= facts.stop_s]
        loads = [s.cpu_percent for s in samples if s.cpu_percent is not None]
        sizes = [s.memory_bytes for s in samples if s.memory_bytes is not None]
        if loads:
            found.append(Measure(f"cpu {label}", "cpu", statistics.fmean(loads), "%"))
        if sizes:
            found.append(Measure(f"memory {label}", "memory", max(sizes) / _MB, "MB"))
    return found


def medians(runs: Sequence[Iterable[Measure]]) -> list[Measure]:
    known: dict[str, list[Measure]] = {}
    for measure in (measure for run in runs for measure in run):
        known.setdefault(measure.name, []).append(measure)
    return [
        replace(found[0], value=statistics.median(m.value for m in found))
        for found in known.values()
    ]


# ---- the file


def write(path: Path, measures: Iterable[Measure]) -> None:
    """Write a baseline; its tolerances may be edited."""
    document = {
        "version": VERSION,
        "tolerances": {
            kind: {"percent": tolerance.percent, "least": tolerance.least}
            for kind, tolerance in TOLERANCES.items()
        },
        "measures": to_document(measures),
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    save(path, strict_json.dumps(document, indent=2, ensure_ascii=False) + "\n")


def to_document(measures: Iterable[Measure]) -> dict[str, dict[str, object]]:
    return {m.name: {"kind": m.kind, "value": round(m.value, 4), "unit": m.unit} for m in measures}


def compare(path: Path, measures: Iterable[Measure]) -> list[Judged]:
    """A verdict for each measure of the baseline; UsageError if that cannot be read."""
    tolerances, base = read(path)
    now = {measure.name: measure for measure in measures}
    judged = []
    for before in base:
        verdict = _compared(before, now.get(before.name), tolerances[before.kind])
        expectation = Expectation(
            kind="baseline",
            subject=before.name,
            name=f"baseline: {before.name}",
            origin=Origin(text=str(path)),
        )
        judged.append(Judged(expectation=expectation, verdict=verdict))
    return judged


def _compared(before: Measure, now: Measure | None, tolerance: Tolerance) -> Verdict:
    low, high = tolerance.limits(before.value)
    limit = f"{low:.3g} to {high:.3g}" if tolerance.both else f"at most {high:.3g}"
    expected = f"{limit} {before.unit} (the baseline is {before.value:.3g})"
    if now is None:
        return Verdict(outcome=Decision.VIOLATED, expected=expected, seen="not measured")
    outcome = Decision.MET if low <= now.value <= high else Decision.VIOLATED
    seen = f"{now.value:.3g} {now.unit}"
    return Verdict(outcome=outcome, expected=expected, seen=seen, value=now.value, unit=now.unit)


def read(path: Path) -> tuple[dict[str, Tolerance], list[Measure]]:
    """(tolerances by kind, measures) of a baseline; UsageError."""
    try:
        document = strict_json.loads(text_file.read(path))
        tolerances = dict(TOLERANCES)
        for kind, given in document.get("tolerances", {}).items():
            base = TOLERANCES[kind]
            percent, least = given.get("percent", base.percent), given.get("least", base.least)
            tolerances[kind] = Tolerance(float(percent), float(least), base.both)
        measures = [
            Measure(name, m["kind"], float(m["value"]), m["unit"])
            for name, m in document["measures"].items()
        ]
    except OSError as error:
        raise UsageError(f"cannot read {path}: {error.strerror}") from None
    except (ValueError, LookupError, TypeError, AttributeError) as error:
        hint = "--update-baseline replaces it"
        raise UsageError(f"{path} is not a baseline: {error}", hint=hint) from None
    unknown = {m.kind for m in measures} - tolerances.keys()
    if unknown:
        raise UsageError(f"{path}: unknown kind of measure '{min(unknown)}'")
    return tolerances, measures
