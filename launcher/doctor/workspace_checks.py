"""The checks of a workspace, which are left out where there is none."""

from __future__ import annotations

import os
import shlex
from collections.abc import Mapping

from launcher.base.model.level import Level
from launcher.base.text import several
from launcher.doctor.doctor_facts import Finding, WorkspaceFacts

_SHOWN = 5  # packages in one line


def check_workspace(facts: WorkspaceFacts) -> list[Finding]:
    """One finding for each thing that is wrong; one in all if nothing is."""
    if facts.error is not None:
        advice = f"build again: {facts.build}"
        return [Finding("workspace", Level.PROBLEM, facts.error, advice)]
    findings = [*_moved(facts), *_builds(facts), *_names(facts), *_overlay(facts)]
    return findings or [Finding("workspace", Level.OK, f"{facts.root}: everything is built")]


def _note(text: str, advice: str) -> Finding:
    return Finding("workspace", Level.NOTE, text, advice)


def _problem(text: str, advice: str) -> Finding:
    return Finding("workspace", Level.PROBLEM, text, advice)


def _moved(facts: WorkspaceFacts) -> list[Finding]:
    if facts.moved_from is None:
        return []
    text = (
        f"it was built in {facts.moved_from}, and moved or copied from there: the links in "
        "install/ still lead there"
    )
    return [_problem(text, facts.build if facts.cleaned else _build_all_afresh(facts))]


def _builds(facts: WorkspaceFacts) -> list[Finding]:
    if facts.moved_from is not None:
        return []  # all packages have to be built
    found = []
    # Packages with a separate finding are built by its repair.
    others = {*facts.broken, *facts.other_python, *facts.no_interpreter}
    changed = {name: why for name, why in facts.changed.items() if name not in others}
    if changed:
        what = _listed({name: f"{name} ({why})" for name, why in changed.items()})
        found.append(_note(f"must be built: {what}", facts.build))
    if facts.broken:
        shown = {name: f"{name} ({path})" for name, path in facts.broken.items()}
        text = f"installed as links into folders that are gone: {_listed(shown)}"
        found.append(_problem(text, facts.build))
    if facts.other_python:
        python = {name: f"{name} (Python {v})" for name, v in facts.other_python.items()}
        advice = _build_afresh(facts, facts.other_python)
        found.append(_problem(f"built for another Python: {_listed(python)}", advice))
    if facts.no_interpreter:
        shown = {name: f"{name} ({path})" for name, path in facts.no_interpreter.items()}
        text = f"programs whose interpreter does not exist any more: {_listed(shown)}"
        advice = _build_afresh(facts, facts.no_interpreter)
        found.append(_problem(text, advice))
    return [*found, *_without_source(facts)]


def _without_source(facts: WorkspaceFacts) -> list[Finding]:
    found = []
    dead = dict.fromkeys(facts.dead, "")
    gone = dict.fromkeys((name for name in facts.gone if name not in dead), "")
    if dead:
        text = f"installed as links to sources that are gone from src/: {_listed(dead)}"
        found.append(_problem(text, f"put the sources back, or: {_forget(facts, dead)}"))
    if gone:
        text = f"installed, but no source in src/: {_listed(gone)}"
        found.append(_note(text, _forget(facts, gone)))
    return found


def _names(facts: WorkspaceFacts) -> list[Finding]:
    found = []
    for name, folders in facts.twice.items():
        text = f"two packages are named {name}: {' and '.join(folders)}"
        advice = f"remove one, or: touch {shlex.quote(os.path.join(folders[-1], 'COLCON_IGNORE'))}"
        found.append(_problem(text, advice))
    if facts.hides:
        shown = {name: f"{name} ({prefix})" for name, prefix in facts.hides.items()}
        text = f"packages that replace those of the environment: {_listed(shown)}"
        advice = "if that is not intended, remove them from src/, then from install/ and build/"
        found.append(_note(text, advice))
    return found


def _overlay(facts: WorkspaceFacts) -> list[Finding]:
    found = []
    if facts.missing_underlays:
        text = (
            f"it was built on {', '.join(facts.missing_underlays)}, which does not exist any more"
        )
        found.append(
            _problem(text, f"put it back; or remove what needs it from src/, then {facts.build}")
        )
    for script in facts.scripts:
        text = f"{script} is not run: it has no .dsv file with its variables"
        found.append(_note(text, f". {shlex.quote(os.path.join(facts.root, 'install/setup.sh'))}"))
    return found


def _listed(shown: Mapping[str, str]) -> str:
    return several([text or name for name, text in sorted(shown.items())], _SHOWN)


def _build_afresh(facts: WorkspaceFacts, names: Mapping[str, str]) -> str:
    if names.keys() <= {*facts.cleaned} & facts.changed.keys() and not facts.is_merged:
        return facts.build
    return f"{_remove(facts, names)} && {facts.build}"


def _build_all_afresh(facts: WorkspaceFacts) -> str:
    root = shlex.quote(facts.root)
    return f"rm -r {root}/build {root}/install && {facts.build}"


def _forget(facts: WorkspaceFacts, names: Mapping[str, str]) -> str:
    return _build_afresh(facts, names) if facts.is_merged else _remove(facts, names)


def _remove(facts: WorkspaceFacts, names: Mapping[str, str]) -> str:
    """The command that removes what was built and installed of some packages.

    All of them if they share a prefix, where the files of each cannot be determined.
    """
    root = shlex.quote(facts.root)
    if facts.is_merged:
        return f"rm -r {root}/build {root}/install"
    folders = [f"{root}/{base}/{name}" for name in sorted(names) for base in ("build", "install")]
    return f"rm -r {' '.join(folders)}"
