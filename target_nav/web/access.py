"""Who may do what: a token for whoever moves the robot or changes a file, nothing for whoever only looks.

The token comes in the first message of a WebSocket, or as `Authorization: Bearer`, never in a cookie and never in the
part of an address that is sent: another site's page cannot use it, and no log keeps it. `Host` is checked as well, for
a name of somebody else's can be made to point to this machine (DNS rebinding).
"""

from __future__ import annotations

import hmac
import ipaddress
import logging
import secrets
import socket
from enum import Enum
from urllib.parse import urlsplit

from target_nav.errors import ConfigError

log = logging.getLogger(__name__)

LEAST_TOKEN = 8
_LOCAL_NAMES = frozenset({"localhost", "localhost.localdomain", "ip6-localhost"})


class Role(str, Enum):
    SPECTATOR = "spectator"
    OPERATOR = "operator"


class Access:
    """
    Args:
        token: what an operator has to show; a random one when None
        names: further host names by which this console is reached

    Raises:
        ConfigError: a token that is guessed too easily.
    """

    def __init__(self, token: str | None = None, names: tuple[str, ...] = ()) -> None:
        if token is not None and len(token) < LEAST_TOKEN:
            raise ConfigError(f"the token has {len(token)} characters; it must have {LEAST_TOKEN} or more")
        self.token = token or secrets.token_urlsafe(16)
        host = socket.gethostname().lower()
        self._names = _LOCAL_NAMES | {host, f"{host}.local"} | {name.lower() for name in names}
        self.refused = 0

    def role(self, token: str | None, peer: str) -> Role | None:
        """None: a wrong token, which is logged. No token at all is a spectator's."""
        if not token:
            return Role.SPECTATOR
        if hmac.compare_digest(token.encode(), self.token.encode()):
            return Role.OPERATOR
        self.refused += 1
        log.warning("refused a wrong token from %s (%d so far)", peer, self.refused)
        return None

    def bearer_role(self, authorization: str | None, peer: str) -> Role | None:
        """The role by an `Authorization` header."""
        scheme, _, token = (authorization or "").partition(" ")
        if scheme and scheme.lower() != "bearer":
            return self.role(authorization, peer)
        return self.role(token.strip(), peer)

    def host_is_ours(self, host: str | None) -> bool:
        """Whether a `Host` header names this machine: by address, or by one of its names."""
        name = urlsplit(f"//{host or ''}").hostname
        if not name:
            return False
        try:
            ipaddress.ip_address(name)
        except ValueError:
            return name.lower() in self._names
        return True

    def origin_is_ours(self, origin: str | None, host: str | None) -> bool:
        """Whether a WebSocket was opened by a page of this console. A program sends no `Origin`, a browser always."""
        if origin is None:
            return True
        parts = urlsplit(origin)
        return (
            parts.scheme in ("http", "https") and bool(host) and parts.netloc.lower() == (host or "").lower()
        )
