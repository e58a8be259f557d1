"""Keys of OpenSSH for the user of a lab and for its hosts."""

from __future__ import annotations

from pathlib import Path

from tests.support.hosts.tool import run_tool


def make_key(path: Path) -> str:
    """Make a key pair without a passphrase; returns the public key without its comment."""
    for file in (path, path.with_name(f"{path.name}.pub")):
        file.unlink(missing_ok=True)
    run_tool("ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-C", "lab", "-f", path)
    return " ".join(path.with_name(f"{path.name}.pub").read_text(encoding="ascii").split()[:2])


def allow_login(home: Path, public_key: str) -> None:
    """Write `authorized_keys` of the user with this home."""
    folder = home / ".ssh"
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    file = folder / "authorized_keys"
    file.write_text(f"{public_key}\n", encoding="ascii")
    file.chmod(0o600)
