"""`export ENGINE TARGET [name:=value ...]`: write a launch file as files of other supervisors."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Sequence

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode, LauncherError, LaunchFileError, UsageError
from launcher.base.option import option
from launcher.base.program import program
from launcher.base.text import count
from launcher.base.verb_table import VERBS
from launcher.launch.launch_options import RUN_OPTIONS, run_options, with_settings_beside
from launcher.launch.target import (
    ABOUT_TARGET,
    DEBUG,
    EVALUATION_TIMEOUT,
    LENIENT,
    SYNOPSIS,
    LaunchRequest,
    parse_words,
)
from launcher.launch.verbs import plan

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.base.model.run_options import RunOptions
    from launcher.export.export_model import ExportedSystem, Unsupported
    from launcher.export.exported_system import HostOf
    from launcher.hosts.file.hosts_model import HostsFile
    from launcher.launch.plan.plan import Plan

ENGINES = ("systemd", "kubernetes", "compose", "podman")
_OF_PROCESSES = ("restart", "stop", "limits", "settings", "settings_beside")

COMMAND = Command(
    "export",
    VERBS["export"],
    arguments=(option("ENGINE", choices=ENGINES), option("[TARGET ...]", name="words")),
    synopsis=f"ENGINE {SYNOPSIS}",
    about=f"""\
Write what a launch file starts as files for another supervisor; nothing is started. ENGINE is
systemd (units), kubernetes (manifests, also for `podman kube play`), compose (compose.yaml), or
podman (Quadlet files). What the engine cannot do is printed, and listed in README.md beside the
files. The same launch file gives the same files. Functions and commands of the launch file are
executed.

{ABOUT_TARGET}""",
    options=(
        option("-o, --out DIR", "folder for the files (default: the name of the engine)"),
        option("--hosts FILE", "the hosts file: which process runs where"),
        option("--strict", "write nothing if something cannot be exported"),
        option(
            "--prefix NAME",
            "begin the names of units, pods and services with NAME (in `launch` and `plan` this "
            "option is about commands)",
            default="",
        ),
        option("--user NAME", "systemd: user of the processes, for hosts that name none"),
        option(
            "--python PATH",
            "systemd: interpreter with the launcher, for processes without a host",
            default="python3",
        ),
        option("--image NAME", "containers: an image of your own, instead of the written recipe"),
        option(
            "--shared-memory",
            "containers: share /dev/shm with the host, instead of using UDP only",
        ),
        LENIENT,
        EVALUATION_TIMEOUT,
        DEBUG,
    ),
    groups=(
        (
            "options about processes",
            tuple(one for one in RUN_OPTIONS if one.name in _OF_PROCESSES),
        ),
    ),
    epilog="exit codes: 0 the files are written, 1 they cannot be written, 2 bad command line, "
    "launch file or hosts file, or with --strict something cannot be exported",
)


def main(words: Sequence[str]) -> int:
    """Export the launch file that `words` name; the exit code."""
    from launcher.export.export_settings import ExportSettings, export
    from launcher.export.folder import Folder

    parsed = parse_words(COMMAND, words)
    _check_prefix(parsed.prefix)
    request = LaunchRequest.of(parsed)
    options = with_settings_beside(run_options(parsed), request.path)
    system = _system(parsed, request, options)
    settings = ExportSettings(
        user=parsed.user,
        python=parsed.python,
        image=parsed.image,
        shared_memory=parsed.shared_memory,
    )
    output = export(parsed.engine, system, settings)
    for gap in output.gaps:
        print(f"{'note' if gap.is_note else 'not exported'}: {gap.line}", file=sys.stderr)
    lost = [gap for gap in output.gaps if not gap.is_note]
    if lost and parsed.strict:
        raise _strict(lost)
    folder = Folder(parsed.out or parsed.engine)
    folder.check(output.files)
    folder.write(output.files)
    exported = count(len(system.processes), "process")
    print(f"{exported} exported to {folder.path}, see README.md there")
    return ExitCode.OK


def _check_prefix(prefix: str) -> None:
    from launcher.export.unit_names import MAX_PREFIX, is_prefix

    if not is_prefix(prefix):
        raise UsageError(
            f"--prefix: '{prefix}' is not a valid prefix",
            hint="a letter of A-Z or a-z, then such letters, digits, '_', '.' and '-'; "
            f"at most {MAX_PREFIX} characters",
        )


def _system(parsed: Parsed, request: LaunchRequest, options: RunOptions) -> ExportedSystem:
    """What the launch file starts; LauncherError for its mistakes and those of the hosts file."""
    file = _hosts_file(parsed.hosts)
    made = evaluated(request, file)
    for surprise in made.warnings:
        print(surprise.render(), file=sys.stderr)
    from launcher.export.exported_system import system_of

    system = system_of(
        made,
        host_of=_placement(file),
        options=options,
        command=_command_line(parsed, request),
        prefix=parsed.prefix,
        discovery=None if file is None else file.discovery,
    )
    if not system.processes:
        raise _nothing(made)
    return system


def evaluated(request: LaunchRequest, file: HostsFile | None) -> Plan:
    """The plan; LauncherError for mistakes in it, or in the rules of the hosts file for it."""
    made = plan.evaluate(request, with_scopes=file is not None)
    errors = [*plan.mistakes_of(made, request), *_misplaced(made, file)]
    if errors:
        from launcher.launch.mistakes import together

        raise together(errors, made.error.fault if made.error else None)
    return made


def _nothing(made: Plan) -> LaunchFileError:
    return LaunchFileError(
        "the launch file starts no process that could be exported",
        hint=f"{program()} plan shows what it does",
        where=made.path,
    )


def _hosts_file(path: str | None) -> HostsFile | None:
    if path is None:
        return None
    from launcher.hosts.file.hosts_reader import read

    return read(path, with_secrets=False)


def _misplaced(made: Plan, file: HostsFile | None) -> Sequence[LauncherError]:
    """What is wrong with the rules of the hosts file for this launch file; prints warnings."""
    if file is None:
        return ()
    from launcher.hosts.launching.placing import place

    findings = place(made, file).findings
    for warning in findings.warnings:
        print(f"warning: {warning}", file=sys.stderr)
    return findings.errors


def _placement(file: HostsFile | None) -> HostOf:
    if file is None:
        return lambda spec: None
    from launcher.hosts.file.placement import Placement

    return Placement(file).host_of


def _command_line(parsed: Parsed, request: LaunchRequest) -> str:
    """The command without paths of this machine and without values that may be secret."""
    from launcher.export.exported_variables import looks_secret

    arguments = [
        f"{name}:={'...' if looks_secret(name) else value}" for name, value in request.arguments
    ]
    hosts = [] if parsed.hosts is None else ["--hosts", os.path.basename(parsed.hosts)]
    words = [parsed.engine, os.path.basename(request.path), *arguments, *hosts]
    return f"launcher export {shlex.join(words)}"


def _strict(lost: Sequence[Unsupported]) -> LaunchFileError:
    return LaunchFileError(
        f"{count(len(lost), 'thing')} of the launch file cannot be exported, nothing is written",
        hint="without --strict the rest is exported",
        where=lost[0].place,
    )
