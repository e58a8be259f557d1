"""Node name: what the bridge of a run is called, where several runs share a domain."""

from __future__ import annotations

import errno
import socket
from pathlib import Path

NODE = "launcher"


class NodeName:
    """`launcher` for the first bridge of a domain on this machine, `launcher_PID` for others.

    PID is that of the run. The first one is who has a name of the kernel's (an abstract socket),
    which goes with the process that has it, however that ends. Keep the object as long as the node.
    """

    def __init__(self, domain_id: int, run_socket: Path) -> None:
        self.text = NODE
        self._claim = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            self._claim.bind(f"\0ros-launcher/domain-{domain_id}/{NODE}".encode())
        except OSError as error:
            if error.errno != errno.EADDRINUSE:
                raise
            self._claim.close()
            self.text = f"{NODE}_{run_socket.name.partition('-')[0]}"

    def close(self) -> None:
        """Leave the name to others."""
        self._claim.close()
