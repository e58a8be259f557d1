"""`python -m launcher.hosts.file.run_order FILE [FOLDER]`: becomes the process of an order.

For orders with paths that can only be found on the host, where no agent runs them. Files of the
order are written to FOLDER, or else beside FILE.
"""

from __future__ import annotations

import os
import sys

from launcher.base import strict_json
from launcher.base.errors import ExitCode, LauncherError
from launcher.hosts.file import order_json
from launcher.hosts.file.resolution import resolve
from launcher.packages.distribution import source_installation
from launcher.packages.workspace import current
from launcher.posix.dispositions import for_exec

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import NoReturn


def main(path: str, folder: str | None = None) -> NoReturn:
    """Replace this process; SystemExit after an error."""
    try:
        with open(path, encoding="utf-8") as file:
            order = order_json.decode(strict_json.unpacked(file.read()))
        enter_workspace()
        found = resolve(order, folder or os.path.dirname(os.path.abspath(path)), os.environ)
        if found.cwd is not None:
            os.chdir(found.cwd)
        words = ("/bin/sh", "-c", " ".join(found.argv)) if order.shell else found.argv
        with for_exec():
            os.execvpe(words[0], words, dict(found.env))
    except LauncherError as error:
        print(error.render(), file=sys.stderr)
    except (OSError, ValueError) as error:
        print(f"error: cannot run '{path}': {error}", file=sys.stderr)
    raise SystemExit(ExitCode.PROCESS_FAILED)


def enter_workspace() -> None:
    """Make visible what `hosts sync` has brought, or the workspace of the folder; UsageError."""
    source_installation()
    workspace = current()
    if workspace is not None:
        from launcher.packages.activation import activate

        activate(workspace)


if __name__ == "__main__":
    main(*sys.argv[1:])
