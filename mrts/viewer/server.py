# SPDX-License-Identifier: MIT
"""The server that a viewer is reached at; needs the extra 'view' (viser)."""

import contextlib
import io
import socket
from errno import EADDRNOTAVAIL
from os import strerror

import viser

from mrts.base.errors import InputError
from mrts.viewer.guard import GuardedServer


def open_server(host: str, port: int, label: str) -> GuardedServer:
    """Start the server, guarded against other pages and other users.

    Args:
        host: Name or address of this machine to listen at.
        port: 0 takes any free one.
        label: Title of the panel.

    Raises:
        InputError: If the address is not one of this machine, the port is taken, or this viser cannot be guarded.
    """
    if not 0 <= port <= 65535:  # noqa: PLR2004 (what a port is)
        raise InputError("--port", "must be from 0 (any free one) to 65535.", value=port)
    try:  # viser would silently take another port, and wait for ever on an address that is not there
        family, _, _, _, listening = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        socket.create_server(listening[:2], family=family).close()
    except (socket.gaierror, UnicodeError):
        raise InputError("--host", "is not a name or address of this machine.", value=host) from None
    except OSError as error:
        where, value = ("--host", host) if error.errno == EADDRNOTAVAIL else ("--port", port)
        reason = strerror(error.errno or 0)
        raise InputError(where, f"cannot be listened at: {reason}. Port 0 is any free one.", value=value) from None
    with contextlib.redirect_stdout(io.StringIO()):  # viser's banner
        server = GuardedServer(host, port, label)
    if port not in {0, server.get_port()}:
        close_server(server)
        raise InputError("--port", "has just been taken. Port 0 is any free one.", value=port)
    return server


def close_server(server: viser.ViserServer) -> None:
    """Stop the server, without a word."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()
