# SPDX-License-Identifier: MIT
"""The server of a viewer: who may reach it, and what may be sent to it; needs the extra 'view' (viser).

Viser lets every page of every browser, and every program on the machine, connect and set whatever it likes.
"""

import contextlib
import hmac
import io
import logging
import secrets
import socket
import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from errno import EADDRNOTAVAIL
from http import HTTPStatus
from ipaddress import ip_address
from math import isfinite
from os import strerror
from typing import Any
from urllib.parse import urlsplit

import msgspec
import viser
import websockets.asyncio.server
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

from mrts.base.errors import InputError

LARGEST_MESSAGE = 16_384
"""From a browser [bytes]: a control's new value or a camera takes some hundred. Who sends more is cut off."""

CAMERA = {"type": "ViewerCameraMessage", "wxyz": (1, 0, 0, 0), "position": (0, 0, 1), "look_at": (0, 0, 0),
          "up_direction": (0, 1, 0), "fov": 1, "near": 0.1, "far": 1, "image_height": 1, "image_width": 1}  # fmt: skip
"""Stands for what a browser says of where it looks from: viser waits for it, and nobody here asks."""


def open_server(host: str, port: int, label: str) -> "GuardedServer":
    """Start the server at a host and a port, 0 for any free one, guarded against other pages and other users.

    Raises:
        InputError: If the address is not one of this machine, the port is taken, or this viser cannot be guarded.
    """
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
        return GuardedServer(host, port, label)


def close_server(server: viser.ViserServer) -> None:
    """Stop the server, without a word, also where a page sends what it cannot be answered any more."""
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection")
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


class GuardedServer(viser.ViserServer):
    """A viser server that is reached only by those who know its address, and takes only what its controls can send.

    Attributes:
        token: First part of the path of every address; another one each run.

    Raises:
        InputError: If this version of viser cannot be guarded.
    """

    def __init__(self, host: str, port: int, label: str) -> None:
        self._host, self.token, self._is_guarded = host, secrets.token_urlsafe(16), False
        with self._guarding():
            super().__init__(host, port, label, verbose=False)
        register = getattr(self.gui, "_gui_input_handle_from_uuid", None)
        if not self._is_guarded or not isinstance(register, dict):
            self.stop()
            raise InputError(
                "viser",
                "this version cannot be guarded against other web pages: pip install 'viser==1.1.1'.",
                value=viser.__version__,
            )

    @property
    def url(self) -> str:
        """Address of the page, as a browser on this machine reaches it; whoever knows it can steer the viewer."""
        host = "localhost" if self._host in {"0.0.0.0", "::"} else self._host  # noqa: S104 (every one, as the user says)
        return f"http://{f'[{host}]' if ':' in host else host}:{self.get_port()}/{self.token}/"

    @property
    def controls(self) -> dict[str, Any]:
        """Viser's handles of all controls, by the identifier that a browser calls each by."""
        return self.gui._gui_input_handle_from_uuid  # noqa: SLF001 (viser tells it no other way)

    @contextlib.contextmanager
    def _guarding(self) -> Iterator[None]:
        """Guard the server that viser starts meanwhile; viser has no setting for that."""
        module, guard = vars(websockets.asyncio.server), self
        serve = module["serve"]
        silent = logging.getLogger("mrts.viewer.connections")  # what strangers send is no news
        silent.disabled = True

        def guarded(
            handler: Callable[[ServerConnection], Any],
            *given: Any,
            process_request: Callable[..., Response | None],
            **options: Any,
        ) -> Any:
            async def checked_handler(connection: ServerConnection) -> None:
                received = connection.recv

                async def recv(decode: bool | None = None) -> Any:  # noqa: FBT001 (websockets' signature)
                    """What a control or a camera can have sent; all else is as if it had not been sent."""
                    while (message := guard.checked(await received(decode))) is None:
                        pass
                    return message

                vars(connection)["recv"] = recv
                await handler(connection)

            def checked_request(connection: ServerConnection, request: Request) -> Response | None:
                token, _, inside = request.path.removeprefix("/").partition("?")[0].partition("/")
                if problem := self._problem(request, token):
                    return connection.respond(HTTPStatus.FORBIDDEN, f"{problem}\n")
                return process_request(connection, replace(request, path=f"/{inside}"))

            options |= {"max_size": LARGEST_MESSAGE, "logger": silent}
            self._is_guarded = True
            return serve(checked_handler, *given, process_request=checked_request, **options)

        module["serve"] = guarded
        try:
            yield
        finally:
            module["serve"] = serve

    def _problem(self, request: Request, token: str) -> str:
        hosts, origins = request.headers.get_all("Host"), request.headers.get_all("Origin")
        if len(hosts) != 1 or not names_this_machine(hosts[0], self._host):
            return "This viewer has another name: start it with --host and the name that you want to reach it by."
        if origins not in ([], [f"http://{hosts[0]}"]):
            return "This viewer answers its own page only."
        if not hmac.compare_digest(token.encode(errors="replace"), self.token.encode()):
            return "Open the whole address that `mrts view` printed."
        return ""

    def checked(self, message: str | bytes) -> bytes | None:
        """A message as viser may read it: values in the range of their control; None for what no control can send."""
        try:
            read = msgspec.msgpack.decode(message) if isinstance(message, bytes) else None
        except (msgspec.MsgspecError, RecursionError, ValueError):
            return None
        match read:
            case {"type": "GuiUpdateMessage" as kind, "uuid": str(uuid), "updates": {"value": value}}:
                possible = _possible(self.controls.get(uuid), value)
                if possible is not None:
                    return msgspec.msgpack.encode({"type": kind, "uuid": uuid, "updates": {"value": possible}})
            case {"type": "ViewerCameraMessage"}:
                return msgspec.msgpack.encode(CAMERA)
        return None


def names_this_machine(header: str, listens: str) -> bool:
    """Whether a Host header names this machine: a name of somebody else's choice may lead here, a number cannot."""
    try:
        name = (urlsplit(f"http://{header}").hostname or "").lower()
    except ValueError:
        return False
    if name in {"localhost", listens.lower()}:
        return True
    if listens == "localhost" or _is_loopback(listens):
        return _is_loopback(name) is True
    return _is_loopback(name) is not None or name == socket.gethostname().lower()


def _is_loopback(host: str) -> bool | None:
    """None for what is no number."""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return None


def _possible(control: Any, value: Any) -> bool | float | str | None:
    """The value nearest to the given one that a control can have; None if it has no such values, or is not seen."""
    if control is None or not control.visible:
        return None
    match control:
        case viser.GuiSliderHandle(disabled=False) if type(value) in {int, float} and isfinite(value):
            return min(max(float(value), control.min), control.max)
        case viser.GuiDropdownHandle(disabled=False):
            return value if isinstance(value, str) and value in control.options else None
        case viser.GuiCheckboxHandle(disabled=False) | viser.GuiButtonHandle(disabled=False) if value in [True, False]:
            return bool(value)
    return None
