"""Sends a fault to a server: `python -m launcher.faults.actions.webhook`.

Standard input has a JSON object with `url`, `headers`, `within_s` and `body`: there, and not on the
command line, other users of the machine cannot read it. It prints one line, without any of these.
"""

from __future__ import annotations

import http.client
import sys
import urllib.error
import urllib.request

from launcher.base import strict_json

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    """Headers with secrets are for the server that was named, and no other."""

    def redirect_request(self, *args: object, **more: object) -> None:
        return None


def send(request: dict[str, Any]) -> tuple[bool, str]:
    """Whether the server has accepted it, and its answer in words."""
    from launcher import __version__

    headers = {"Content-Type": "application/json", "User-Agent": f"launcher/{__version__}"}
    call = urllib.request.Request(
        request["url"],
        data=strict_json.packed(request["body"]).encode(),
        headers={**headers, **request["headers"]},
        method="POST",
    )
    try:
        opener = urllib.request.build_opener(_NoRedirect)
        with opener.open(call, timeout=request["within_s"]) as answer:
            return True, f"the server has answered {answer.status}"
    except urllib.error.HTTPError as error:
        return False, f"the server has answered {error.code}"
    except OSError as error:
        reason = getattr(error, "reason", error)
        return False, getattr(reason, "strerror", None) or type(reason).__name__
    except (ValueError, http.client.HTTPException) as error:
        return False, type(error).__name__  # its text may have a header


def main() -> int:
    ok, text = send(strict_json.loads(sys.stdin.read()))
    print(text)
    return 0 if ok else 1


if __name__ == "__main__":
    sys.exit(main())
