"""Options of OpenSSH in a hosts file: which there are, and which the launcher sets itself."""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Mapping

from launcher.base.document.fields import FieldError, FieldType, near, raise_all

_NAMES = """
AddKeysToAgent AddressFamily BindAddress BindInterface CASignatureAlgorithms CanonicalDomains
CanonicalizeFallbackLocal CanonicalizeHostname CanonicalizeMaxDots CanonicalizePermittedCNAMEs
CertificateFile ChannelTimeout CheckHostIP Ciphers ClearAllForwardings Compression
ConnectTimeout ConnectionAttempts DynamicForward EnableEscapeCommandline EnableSSHKeysign
EscapeChar ExitOnForwardFailure FingerprintHash ForwardAgent ForwardX11 ForwardX11Timeout
ForwardX11Trusted GSSAPIAuthentication GSSAPIDelegateCredentials GatewayPorts GlobalKnownHostsFile
HashKnownHosts HostKeyAlgorithms HostKeyAlias HostbasedAcceptedAlgorithms HostbasedAuthentication
IPQoS IdentitiesOnly IdentityAgent IdentityFile IgnoreUnknown KbdInteractiveAuthentication
KbdInteractiveDevices KexAlgorithms LocalForward LogLevel LogVerbose MACs
NoHostAuthenticationForLocalhost ObscureKeystrokeTiming PKCS11Provider PasswordAuthentication
Port PreferredAuthentications ProxyCommand ProxyJump ProxyUseFdpass PubkeyAcceptedAlgorithms
PubkeyAuthentication RekeyLimit RemoteForward RequiredRSASize RevokedHostKeys SecurityKeyProvider
SendEnv ServerAliveCountMax ServerAliveInterval StreamLocalBindMask StreamLocalBindUnlink
StrictHostKeyChecking SyslogFacility TCPKeepAlive Tag Tunnel TunnelDevice UpdateHostKeys
UserKnownHostsFile VisualHostKey XAuthLocation
"""
# Other options of OpenSSH, with the reason why a hosts file cannot set them.
_OWN_MASTER = "the launcher opens a separate master connection to each host"
_OWN_COMMAND = "the launcher runs its own command on the host"
_OTHER_KEYS = "keys of hosts are trusted only if they are in files of known hosts"
REFUSED: Mapping[str, str] = {
    "BatchMode": "the launcher never asks for a password, since nodes have the terminal",
    "ControlMaster": _OWN_MASTER,
    "ControlPath": _OWN_MASTER,
    "ControlPersist": _OWN_MASTER,
    "ForkAfterAuthentication": "the connection is supervised as a child of the launcher",
    "Host": "the host is that of 'address'",
    "Hostname": "the host is that of 'address'",
    "Include": "options are given by name here; files are read by ssh itself (~/.ssh/config)",
    "KnownHostsCommand": _OTHER_KEYS,
    "LocalCommand": _OWN_COMMAND,
    "Match": "options are given for each host here",
    "PermitLocalCommand": _OWN_COMMAND,
    "RemoteCommand": _OWN_COMMAND,
    "RequestTTY": "the connection carries binary messages, which a terminal would change",
    "SessionType": _OWN_COMMAND,
    "SetEnv": "its values would be visible in the list of processes; use 'environment'",
    "StdinNull": "orders go through standard input",
    "User": "the user is that of 'user'",
    "VerifyHostKeyDNS": _OTHER_KEYS,
}
KNOWN: tuple[str, ...] = tuple(_NAMES.split())
_BY_LOWER = {name.lower(): name for name in (*KNOWN, *REFUSED)}
_STRICT = ("yes", "true", "accept-new")
# What is there is no file, or goes with the process.
_NO_FILES = ("/dev/", "/proc/", "/sys/")
_TOKEN = re.compile(r"%(.)|\$\{(\w+)\}")
_MOST_LINKS = 40


def parse(value: object) -> dict[str, str]:
    """Options by their proper names; FieldError."""
    if not isinstance(value, Mapping):
        hint = "as in {Port: 22, IdentityFile: ~/.ssh/fleet}"
        raise FieldError("expected options of ssh by name", hint=hint)
    options: dict[str, str] = {}
    errors: list[FieldError] = []
    for given, text in value.items():
        try:
            name = _name(given)
            if name in options:
                raise FieldError(f"ssh option '{name}' is given twice", (given,), key=True)
            options[name] = _value(name, text, given)
        except FieldError as error:
            errors.append(error)
    raise_all(errors)
    return options


def trusts_each_time(options: Mapping[str, str]) -> bool:
    """`accept-new` trusts a host the first time, which is each time if no file remembers it.

    ssh goes on if it cannot write the key. It writes it to the first file of UserKnownHostsFile.
    """
    if options.get("StrictHostKeyChecking") != "accept-new":
        return False
    first = next(iter(_words(options.get("UserKnownHostsFile", ""))), "#")
    return not first.startswith("#") and (first.lower() == "none" or not _remembers(first))


def _words(value: str) -> list[str]:
    """The arguments in a value; quotes that are not closed are ssh's to refuse."""
    lexer = shlex.shlex(value, posix=True)
    lexer.whitespace_split, lexer.commenters, lexer.escape = True, "", ""
    try:
        return list(lexer)
    except ValueError:
        return []


def _remembers(word: str) -> bool:
    """Whether ssh can keep a key in this file: it is a regular one, or can become one."""
    path = os.path.abspath(os.path.expanduser(_TOKEN.sub(_expanded, word)))
    for _ in range(_MOST_LINKS):
        folder = os.path.realpath(os.path.dirname(path))
        path = os.path.join(folder, os.path.basename(path))
        if path.startswith(_NO_FILES) and not path.startswith("/dev/shm/"):
            return False
        if not os.path.islink(path):
            break
        path = os.path.join(folder, os.readlink(path))
    else:
        return False
    if "%" in folder or folder == os.path.realpath(os.path.expanduser("~/.ssh")):
        folder = ""  # of a token that is known later, or one that ssh makes
    if os.path.exists(path):
        return os.path.isfile(path) and os.access(path, os.W_OK)
    return not folder or (os.path.isdir(folder) and os.access(folder, os.W_OK | os.X_OK))


def _expanded(token: re.Match[str]) -> str:
    if token[2] is not None:
        return os.environ.get(token[2], token[0])
    known = {"%": "%", "d": os.path.expanduser("~"), "i": str(os.getuid())}
    return known.get(token[1], token[0])


def _name(given: object) -> str:
    name = _BY_LOWER.get(str(given).lower())
    if name is None:
        hint = near(given, KNOWN) or ""
        hint = "see ssh_config(5)" if hint.startswith("known:") else hint
        raise FieldError(f"unknown ssh option '{given}'", (given,), hint, key=True)
    if name in REFUSED:
        message = f"ssh option '{name}' cannot be set: {REFUSED[name]}"
        raise FieldError(message, (given,), key=True)
    return name


def _value(name: str, value: object, given: object) -> str:
    if not isinstance(value, str) or not value.strip():
        raise FieldError(f"ssh option '{name}' needs a value", (given,))
    if any(not char.isprintable() for char in value):
        raise FieldError(f"ssh option '{name}' has a control character", (given,))
    if name == "StrictHostKeyChecking" and value not in _STRICT:
        # Only these as they are: ssh ignores quotes and blanks around a value.
        hint = "yes (the default), or accept-new, which trusts a host the first time"
        message = f"'{value}' would trust a machine that pretends to be the host"
        raise FieldError(message, (given,), hint)
    if name == "Port" and not (value.isascii() and value.isdigit() and 0 < int(value[:6]) < 65536):
        raise FieldError(f"'{value}' is not a port: expected 1 to 65535", (given,))
    return value


_SCALAR = {"type": ["string", "number", "boolean"]}
_SCHEMAS: Mapping[str, Mapping[str, object]] = {
    "Port": {
        "anyOf": [
            {"type": "integer", "minimum": 1, "maximum": 65535},
            {"type": "string", "pattern": "^[0-9]+$"},
        ]
    },
    "StrictHostKeyChecking": {"enum": ["yes", "accept-new", True]},
}
SSH_OPTIONS = FieldType(
    parse,
    {
        "type": "object",
        "properties": {name: _SCHEMAS.get(name, _SCALAR) for name in KNOWN},
        "additionalProperties": False,
    },
)
