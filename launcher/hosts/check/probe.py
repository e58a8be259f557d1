"""What `hosts check` runs on every host, and on this machine: it collects facts, and then answers.

The file is sent to a Python that may be old and may have no launcher, so it uses nothing of ours
unless it is there. Both directions are lines of JSON. The first request has what is looked for;
its answer are the facts. After it: `ping`, answered with the time; `peer`, an address to which
datagrams are sent until `enough`. What arrives is reported as `heard`. It ends with its input.
"""

from __future__ import annotations

import contextlib
import glob
import json
import os
import platform
import re
import select
import socket
import subprocess
import sys
import time

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterator
    from typing import Any

GROUP = "239.255.0.1"  # of the announcements of DDS
MARK = "launcher-check"  # the first word of a datagram
PERIOD_S = 0.1  # between datagrams to one address
PARTICIPANTS = 120  # of a domain that have separate ports
# Variables that decide who discovers whom, and what is compared between hosts. None is secret.
SETTINGS = (
    "ROS_DOMAIN_ID",
    "ROS_DISTRO",
    "RMW_IMPLEMENTATION",
    "ROS_AUTOMATIC_DISCOVERY_RANGE",
    "ROS_LOCALHOST_ONLY",
    "ROS_STATIC_PEERS",
    "ROS_DISCOVERY_SERVER",
    "ROS_SUPER_CLIENT",
    "FASTDDS_BUILTIN_TRANSPORTS",
)


def main() -> None:
    """Serve until the input ends."""
    lines = Lines(0)
    request = json.loads(lines.next())
    os.environ.update(request["environment"])
    network = Network(request)
    say({"facts": facts(request, network)})
    while True:
        fds = [0, *network.sockets]
        readable, _, _ = select.select(fds, [], [], network.wait_s())
        network.receive([fd for fd in readable if fd != 0])
        network.send()
        if 0 in readable and not lines.read():
            return
        for line in lines.complete():
            serve(json.loads(line), network)


def serve(request: dict[str, Any], network: Network) -> None:
    if "ping" in request:
        say({"pong": request["ping"], "time": time.time()})
    elif "peer" in request:
        network.peers[request["peer"]] = (request["address"], request["ports"])
    elif "enough" in request:
        network.peers.pop(request["enough"], None)


def say(document: dict[str, Any]) -> None:
    data = json.dumps(document).encode() + b"\n"
    while data:
        data = data[os.write(1, data) :]


class Lines:
    """Lines from a descriptor that is also waited for."""

    def __init__(self, fd: int) -> None:
        self._fd = fd
        self._rest = b""

    def read(self) -> bool:
        block = os.read(self._fd, 65536)
        self._rest += block
        return bool(block)

    def complete(self) -> list[bytes]:
        *lines, self._rest = self._rest.split(b"\n")
        return lines

    def next(self) -> bytes:
        """The next line; it is the only one that has been sent."""
        while True:
            found = self.complete()
            if found:
                return found[0]
            if not self.read():
                sys.exit(1)


# ---- the network


class Network:
    """Datagrams on the ports that a participant of the domain would have."""

    def __init__(self, request: dict[str, Any]) -> None:
        self._name = request["name"]
        self._nonce = request["nonce"]
        self._heard: list[str] = []
        self._next_s = time.monotonic()
        self.peers: dict[str, tuple[str, dict[str, int]]] = {}
        self.addresses = addresses()
        self.base = 7400 + 250 * request["domain"]
        self.ports: dict[str, int] = {}
        self.errors: dict[str, str] = {}
        self.sockets: dict[int, tuple[str, socket.socket]] = {}
        self._sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._open("unicast", [self.base + 10 + 2 * index for index in range(PARTICIPANTS)])
        self._open_multicast()
        if request.get("server_port"):
            self._open("server", [request["server_port"]])

    def _open(self, kind: str, ports: list[int]) -> None:
        one = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        for port in ports:
            try:
                one.bind(("", port))
            except OSError as error:
                self.errors[kind] = f"port {port}: {error.strerror}"
                continue
            self.sockets[one.fileno()] = (kind, one)
            self.ports[kind] = port
            self.errors.pop(kind, None)
            return
        one.close()

    def _open_multicast(self) -> None:
        one = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        one.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            one.bind(("", self.base))
        except OSError as error:
            self.errors["multicast"] = f"port {self.base}: {error.strerror}"
            one.close()
            return
        for address in self.addresses:
            member = socket.inet_aton(GROUP) + socket.inet_aton(address)
            with contextlib.suppress(OSError):  # an interface without multicast
                one.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)
        self.sockets[one.fileno()] = ("multicast", one)
        self.ports["multicast"] = self.base

    def wait_s(self) -> float | None:
        return max(0.0, self._next_s - time.monotonic()) if self.peers else None

    def send(self) -> None:
        """One datagram of each kind to each peer, now and then."""
        if not self.peers or time.monotonic() < self._next_s:
            return
        self._next_s = time.monotonic() + PERIOD_S
        for address, ports in self.peers.values():
            for kind in ("unicast", "server"):
                if kind in ports:
                    self._send(kind, (address, ports[kind]))
        for own in self.addresses:
            with contextlib.suppress(OSError):
                option = socket.inet_aton(own)
                self._sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, option)
                self._send("multicast", (GROUP, self.base))

    def _send(self, kind: str, to: tuple[str, int]) -> None:
        text = " ".join([MARK, self._nonce, kind, self._name])
        try:
            self._sender.sendto(text.encode(), to)
        except OSError as error:
            self.errors.setdefault("send " + kind, error.strerror or str(error))

    def receive(self, readable: list[int]) -> None:
        for fd in readable:
            kind, one = self.sockets[fd]
            data, source = one.recvfrom(2048)
            words = data.decode("utf-8", "replace").split(" ")
            if words[:2] != [MARK, self._nonce] or len(words) != 4 or words[3] == self._name:
                continue  # of DDS, of another check, or our own
            seen = f"{words[2]} {words[3]}"
            if words[2] == kind and seen not in self._heard:
                self._heard.append(seen)
                say({"heard": words[3], "kind": words[2], "source": source[0]})


def addresses() -> list[str]:
    """The IPv4 addresses of this machine, without those of the loopback interface."""
    found: list[str] = []
    last = ""
    for line in read("/proc/net/fib_trie").splitlines():
        words = line.split()
        if words[:1] == ["|--"]:
            last = words[1]
        elif words[:3] == ["/32", "host", "LOCAL"] and not last.startswith("127."):
            found.append(last)
    return sorted(set(found))


# ---- facts


def facts(request: dict[str, Any], network: Network) -> dict[str, Any]:
    shm = os.stat("/dev/shm") if os.path.isdir("/dev/shm") else None
    return {
        "python": list(sys.version_info[:3]),
        "executable": sys.executable,
        "machine": platform.machine(),
        "uid": os.getuid(),
        "client": os.environ.get("SSH_CONNECTION", "").partition(" ")[0],
        "settings": {name: os.environ[name] for name in SETTINGS if name in os.environ},
        "boot_id": read("/proc/sys/kernel/random/boot_id").strip(),
        "machine_id": read("/etc/machine-id").strip(),
        "shared_memory": None if shm is None else shm.st_dev,
        "addresses": network.addresses,
        "ports": network.ports,
        "port_errors": network.errors,
        "folders": [folder(path) for path in request["folders"]],
        "max_sessions": max_sessions(),
        **systemd(),
        **software(request),
    }


def read(path: str) -> str:
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            return file.read()
    except OSError:
        return ""


def output(words: list[str]) -> str:
    """What a program prints; empty if there is none, or if it fails."""
    try:
        done = subprocess.run(
            words,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=3,
            check=False,
        )
    except (OSError, subprocess.SubprocessError):
        return ""
    return done.stdout.decode("utf-8", "replace") if done.returncode == 0 else ""


def folder(path: str) -> dict[str, Any]:
    """Free space where this folder is, or will be."""
    full = os.path.join(os.path.expanduser("~"), os.path.expanduser(path))
    existing = full
    while not os.path.isdir(existing) and existing != os.path.dirname(existing):
        existing = os.path.dirname(existing)
    found: dict[str, Any] = {"path": path, "existing": existing}
    try:
        status = os.statvfs(existing)
    except OSError as error:
        return {**found, "error": error.strerror}
    return {
        **found,
        "total": status.f_blocks * status.f_frsize,
        "free": status.f_bavail * status.f_frsize,
        "inodes": status.f_files,
        "free_inodes": status.f_favail,
        "writable": os.access(existing, os.W_OK | os.X_OK) and not status.f_flag & os.ST_RDONLY,
    }


def systemd() -> dict[str, Any]:
    """The version of systemd if the machine was booted with it, and whether this user has it."""
    if not os.path.isdir("/run/systemd/system"):
        return {"systemd": None, "manager": False, "lingers": False}
    first = output(["systemctl", "--version"]).partition("\n")[0].split()
    uid = os.getuid()
    runtime = f"/run/user/{uid}/systemd/private"
    return {
        "systemd": first[1] if len(first) > 1 else "?",
        "manager": uid == 0 or os.path.exists(runtime),
        "lingers": uid == 0 or os.path.exists("/var/lib/systemd/linger/" + user_name()),
    }


def user_name() -> str:
    import pwd

    try:
        return pwd.getpwuid(os.getuid()).pw_name
    except KeyError:
        return str(os.getuid())


def max_sessions() -> int:
    """Of one connection with sshd; 10, its default, if its configuration cannot be read."""
    found = re.search(r"(?m)^maxsessions (\d+)$", output(["/usr/sbin/sshd", "-T"]))
    if found:
        return int(found.group(1))
    texts = [read("/etc/ssh/sshd_config")]
    for pattern in re.findall(r"(?im)^\s*include\s+(\S+)", texts[0]):
        texts[:0] = map(read, sorted(glob.glob(os.path.join("/etc/ssh", pattern))))
    values = re.findall(r"(?im)^\s*maxsessions[\s=]+(\d+)", "\n".join(texts))
    return int(values[0]) if values else 10  # sshd takes the first


# ---- software


def software(request: dict[str, Any]) -> dict[str, Any]:
    version, protocol, code = launcher_versions()
    missing: dict[str, Any] = {"packages": [], "executables": [], "interfaces": []}
    unchecked = ""
    if version is not None:
        try:
            missing = missing_there(request)
        except Exception as error:  # of another version
            unchecked = ": ".join(filter(None, (type(error).__name__, str(error))))
    return {
        "version": version,
        "protocol": protocol,
        "code": code,
        "missing": missing,
        "unchecked": unchecked,
        "rclpy": package_version("rclpy"),
        "middlewares": middlewares(),
    }


def launcher_versions() -> tuple[str | None, int | None, str | None]:
    """Of the launcher, of the protocol of its agent, and which code it is."""
    version = None
    try:
        import launcher

        version = str(launcher.__version__)
        from launcher.hosts.identity import PROTOCOL, code_id
    except Exception:
        return version, None, None
    return version, PROTOCOL, code_id()


def prefixes() -> Iterator[str]:
    for path in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if path:
            yield path
    yield sys.prefix


def missing_there(request: dict[str, Any]) -> dict[str, Any]:
    """As the launcher there finds them when it starts processes."""
    from launcher.base.errors import LauncherError
    from launcher.hosts.file.run_order import enter_workspace
    from launcher.packages import finder

    enter_workspace()
    missing: dict[str, Any] = {"packages": [], "executables": [], "interfaces": []}
    for name in request["packages"]:
        try:
            finder.package_prefix(name, os.environ)
        except LauncherError:
            missing["packages"].append(name)
    for package, name in request["executables"]:
        try:
            finder.find_executable(package, name, os.environ)
        except LauncherError:
            missing["executables"].append([package, name])
    for name in request["interfaces"]:
        if finder.resource_prefix("rosidl_interfaces", name, os.environ) is None:
            missing["interfaces"].append(name)
    return missing


def package_version(name: str) -> str | None:
    for prefix in prefixes():
        text = read(os.path.join(prefix, "share", name, "package.xml"))
        found = re.search(r"<version>\s*([^<\s]+)\s*</version>", text)
        if found:
            return found.group(1)
    return None


def middlewares() -> list[str]:
    """The implementations of the middleware that are installed."""
    place = "share/ament_index/resource_index/rmw_typesupport"
    found = [glob.glob(os.path.join(prefix, place, "rmw_*")) for prefix in prefixes()]
    return sorted({os.path.basename(path) for paths in found for path in paths})


if __name__ == "__main__":
    main()
