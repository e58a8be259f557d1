"""`hosts check`: try each host of a hosts file, and say what is wrong."""

from __future__ import annotations

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode
from launcher.base.option import DEBUG, JSON, option, positive_seconds
from launcher.hosts.verbs.hosts_options import HOSTS, hosts_file
from launcher.launch.target import (
    ABOUT_TARGET,
    EVALUATION_TIMEOUT,
    SYNOPSIS,
    TARGET,
    LaunchRequest,
)
from launcher.run.part_options import DISCOVERY

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.hosts.check.host_findings import Needs
    from launcher.hosts.file.hosts_model import HostsFile


def _check(parsed: Parsed) -> int:
    from launcher.hosts.check.check_report import as_document, as_text
    from launcher.hosts.check.examine import examine
    from launcher.posix.domains import environment_domain
    from launcher.posix.stdio import print_text

    file = hosts_file(parsed)
    result = examine(
        file,
        file.discovery.by(parsed.discovery),
        _needs(parsed, file) if parsed.words else {},
        domain=environment_domain(),
        timeout_s=parsed.timeout,
    )
    if parsed.json:
        from launcher.posix.json_output import print_document

        print_document(as_document(result))
    else:
        print_text(as_text(result))
    return ExitCode.OK if result.is_well else ExitCode.PROCESS_FAILED


def _needs(parsed: Parsed, file: HostsFile) -> dict[str, Needs]:
    """What the plan needs on each host; LauncherError if the launch file is wrong."""
    from launcher.hosts.check.needs import needs_of
    from launcher.hosts.launching.placing import place
    from launcher.launch.mistakes import together
    from launcher.launch.verbs.plan import evaluate, mistakes_of

    request = LaunchRequest.of(parsed)
    plan = evaluate(request, with_scopes=True)
    errors = mistakes_of(plan, request)
    placing = place(plan, file)
    if errors or placing.findings.errors:
        raise together([*errors, *placing.findings.errors])
    return {
        name: needs_of(
            [one.order for one in placing.placed if one.order and one.host_name == name],
            plan.environment,
        )
        for name in file.hosts
    }


CHECK = Command(
    "hosts check",
    "try each host of a hosts file, and say what is wrong",
    arguments=(TARGET,),
    synopsis=f"[{SYNOPSIS.removesuffix(' [options]')}] [options]",
    options=(
        HOSTS,
        DISCOVERY,
        option("--timeout S", "longest wait for a host", positive_seconds, 5.0),
        JSON,
        EVALUATION_TIMEOUT,
        DEBUG,
    ),
    about=f"""\
Log in to all hosts at the same time, and to find what would keep a run from working: login, Python
and launcher, engine, clock, ROS distribution, middleware and domain, space on disks, and whether
UDP and multicast reach every host from every other. With TARGET also whether each host has the
packages, executables and message packages that its processes need. Nothing is left on the hosts.

{ABOUT_TARGET}""",
    epilog="exit codes: 0 no problem (notes do not count), 1 a problem, 2 bad command line "
    "or bad file",
    run=_check,
)
