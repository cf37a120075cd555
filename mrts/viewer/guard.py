# SPDX-License-Identifier: MIT
"""Who may reach a viewer, and what may be sent to it; needs the extra 'view'.

Viser lets every page of every browser, and every program on the machine, connect and set whatever it likes.
"""

import hmac
import logging
import secrets
import socket
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from http import HTTPStatus
from ipaddress import ip_address
from math import hypot, isfinite
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

POLICY = (
    "default-src 'self' data: blob: 'unsafe-inline' 'unsafe-eval'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""What the page may do: it is one file that compiles its scripts; nothing comes from another server or goes to one."""

HEADERS = {
    "Referrer-Policy": "no-referrer",
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
    "Content-Security-Policy": POLICY,
    "Cache-Control": "no-store",
}
"""The address holds the token: it goes to no other site, and no other site shows the page in a frame."""

LONGEST_TEXT = 200
"""Of a text field: a name of a file."""

FARTHEST = 1e3
"""Where a gizmo can be dragged to along an axis [m]."""

SMALLEST_QUATERNION = 1e-3
"""Length below which a quaternion has no direction; a browser sends them with length 1."""

Value = bool | int | float | str
ProcessRequest = Callable[[ServerConnection, Request], Response | None]


CAMERA = {"wxyz": 4, "position": 3, "look_at": 3, "up_direction": 3,
          **dict.fromkeys(("fov", "near", "far", "image_height", "image_width"), 0)}  # fmt: skip
"""What a browser says of where it looks from: how many numbers each, 0 for a single one."""

GIZMO_MOVED = "TransformControlsUpdateMessage"
GIZMO_EVENTS = {GIZMO_MOVED, "TransformControlsDragStartMessage", "TransformControlsDragEndMessage"}


class GuardedServer(viser.ViserServer):
    """A viser server that is reached only by those who know its address, and takes only what its controls can send.

    Args:
        host: Name or address of this machine to listen at.
        port: 0 takes any free one.
        label: Title of the panel.

    Raises:
        InputError: If this version of viser cannot be guarded.
    """

    def __init__(self, host: str, port: int, label: str) -> None:
        guard = self.guard = ViewerGuard(host, self._control, self._has_gizmo)
        with guard.serving():
            super().__init__(host, port, label, verbose=False)
        registers = (
            getattr(self.gui, "_gui_input_handle_from_uuid", None),
            getattr(self.scene, "_handle_from_transform_controls_name", None),
        )
        if not guard.is_set or not all(isinstance(register, dict) for register in registers):
            self.stop()
            raise InputError(
                "viser",
                "this version cannot be guarded against other web pages: pip install 'viser==1.1.1'.",
                value=viser.__version__,
            )

    @property
    def url(self) -> str:
        """Address of the page, as a browser on this machine reaches it; whoever knows it can steer the viewer."""
        host = self.guard.host
        host = "localhost" if host in {"0.0.0.0", "::"} else host  # noqa: S104 (every address, on the user's word)
        return f"http://{f'[{host}]' if ':' in host else host}:{self.get_port()}/{self.guard.token}/"

    @property
    def controls(self) -> dict[str, Any]:
        """Viser's handles of all controls, by the identifier that a browser calls each by."""
        return self.gui._gui_input_handle_from_uuid  # noqa: SLF001 (viser tells it no other way)

    @property
    def gizmos(self) -> dict[str, Any]:
        """Viser's handles of all gizmos, by name."""
        return self.scene._handle_from_transform_controls_name  # noqa: SLF001 (likewise)

    def _control(self, uuid: str) -> object:
        """The control with an identifier, if it is to be seen."""
        control = self.controls.get(uuid)
        return control if control is not None and control.visible else None

    def _has_gizmo(self, name: str) -> bool:
        """Whether there is such a gizmo to be seen."""
        gizmo = self.gizmos.get(name)
        return gizmo is not None and bool(gizmo.visible)


class ViewerGuard:
    """Checks requests and messages before viser sees them.

    Args:
        host: Where the viewer listens.
        control: The control with an identifier of viser's, None if there is none.
        has_gizmo: Whether a gizmo of a name can be dragged.

    Attributes:
        host: As given.
        token: First part of the path of every address; another one each run.
        is_set: Whether a server is guarded.
    """

    def __init__(
        self, host: str, control: Callable[[str], object], has_gizmo: Callable[[str], bool] = lambda _name: False
    ) -> None:
        self.host = host
        self.token = secrets.token_urlsafe(16)
        self.is_set = False
        self._control, self._has_gizmo = control, has_gizmo

    @contextmanager
    def serving(self) -> Iterator[None]:
        """Guard the server that viser starts meanwhile; viser has no setting for that."""
        module = vars(websockets.asyncio.server)
        serve = module["serve"]
        silent = logging.getLogger("mrts.viewer.connections")  # what strangers send is no news
        silent.disabled = True
        settings = {"max_size": LARGEST_MESSAGE, "create_connection": self._connection_type(), "logger": silent}

        def guarded(*given: Any, **options: Any) -> Any:
            options |= settings | {"process_request": self._checked_requests(options["process_request"])}
            self.is_set = True
            return serve(*given, **options)

        module["serve"] = guarded
        try:
            yield
        finally:
            module["serve"] = serve

    def _checked_requests(self, answer: ProcessRequest) -> ProcessRequest:
        """Viser's answers to requests for its page or a websocket, to those who may ask."""

        def process_request(connection: ServerConnection, request: Request) -> Response | None:
            token, _, inside = request.path.removeprefix("/").partition("?")[0].partition("/")
            if problem := self._problem(request, token):
                return connection.respond(HTTPStatus.FORBIDDEN, f"{problem}\n")
            response = answer(connection, replace(request, path=f"/{inside}"))
            if response is not None:
                response.headers.update(HEADERS)
            return response

        return process_request

    def _problem(self, request: Request, token: str) -> str:
        """Why a request is refused; empty if it is not."""
        hosts, origins = request.headers.get_all("Host"), request.headers.get_all("Origin")
        if len(hosts) != 1 or not self.answers_to(hosts[0]):
            return "This viewer has another name: start it with --host and the name that you want to reach it by."
        if origins not in ([], [f"http://{hosts[0]}"]):
            return "This viewer answers its own page only."
        if not hmac.compare_digest(token.encode(errors="replace"), self.token.encode()):
            return "Open the whole address that `mrts view` printed."
        versions = request.headers.get_all("Sec-WebSocket-Protocol")
        if "Upgrade" in request.headers and versions != [f"viser-v{viser.__version__}"]:
            return "This page is of another version of viser: open it again."
        return ""

    def answers_to(self, host: str) -> bool:
        """Whether a Host header names this machine: a name of somebody else's choice may lead here, a number cannot.

        Args:
            host: The header.
        """
        try:
            name = (urlsplit(f"http://{host}").hostname or "").lower()
        except ValueError:
            return False
        if name in {"localhost", self.host.lower()}:
            return True
        only_local = self.host == "localhost" or _is_loopback(self.host)
        try:
            return ip_address(name).is_loopback or not only_local
        except ValueError:
            return not only_local and name == socket.gethostname().lower()

    def _connection_type(self) -> type[ServerConnection]:
        guard = self

        class Connection(ServerConnection):
            """Hands on what a control or a camera can have sent; all else is as if it had not been sent."""

            async def recv(self, decode: bool | None = None) -> Any:  # noqa: FBT001 (websockets' signature)
                while True:
                    message = guard.checked(await super().recv(decode))
                    if message is not None:
                        return message

        return Connection

    def checked(self, message: str | bytes) -> bytes | None:
        """A message as viser may read it: values in the range of their control; None for what no control can send.

        Args:
            message: As it came.
        """
        if not isinstance(message, bytes):
            return None
        try:
            allowed = self._allowed(msgspec.msgpack.decode(message))
        except (msgspec.MsgspecError, RecursionError, ValueError):
            return None
        return None if allowed is None else msgspec.msgpack.encode(allowed)

    def _allowed(self, read: Any) -> dict[str, Any] | None:
        """What of a message a control, a camera or a gizmo can have sent; None for any other."""
        match read:
            case {"type": "GuiUpdateMessage" as kind, "uuid": str(uuid), "updates": {"value": value}}:
                possible = _possible(self._control(uuid), value)
                return None if possible is None else {"type": kind, "uuid": uuid, "updates": {"value": possible}}
            case {"type": "ViewerCameraMessage" as kind}:
                camera = _numbers(read, CAMERA)
                return None if camera is None else {"type": kind, **camera}
            case {"type": str(kind), "name": str(name)} if kind in GIZMO_EVENTS and read.get("owner", "") == "":
                moved = _pose(read) if kind == GIZMO_MOVED else {}
                return None if moved is None or not self._has_gizmo(name) else {"type": kind, "name": name, **moved}
        return None


def _numbers(read: Mapping[str, Any], lengths: Mapping[str, int]) -> dict[str, Any] | None:
    """Finite numbers of a message by name; None if one of them is none."""
    for name, length in lengths.items():
        parts = read.get(name) if length else [read.get(name)]
        if not isinstance(parts, list) or len(parts) != max(length, 1):
            return None
        if not all(isinstance(part, int | float) and not isinstance(part, bool) and isfinite(part) for part in parts):
            return None
    return {name: read[name] for name in lengths}


def _pose(read: Mapping[str, Any]) -> dict[str, Any] | None:
    """Where a gizmo was dragged to, with a quaternion of length 1; None for what is no pose near the scene."""
    pose = _numbers(read, {"wxyz": 4, "position": 3})
    if pose is None or hypot(*pose["wxyz"]) < SMALLEST_QUATERNION or max(map(abs, pose["position"])) > FARTHEST:
        return None
    size = hypot(*pose["wxyz"])
    return pose | {"wxyz": [part / size for part in pose["wxyz"]]} if isfinite(size) else None


def _possible(control: object, value: Any) -> Value | None:
    """The value nearest to the given one that a control can have; None if it has no such values."""
    match control:
        case viser.GuiSliderHandle(disabled=False) if _numbers({"": value}, {"": 0}):
            return min(max(float(value), control.min), control.max)
        case viser.GuiDropdownHandle(disabled=False) | viser.GuiButtonGroupHandle(disabled=False):
            return value if isinstance(value, str) and value in control.options else None
        case viser.GuiTextHandle(disabled=False) if isinstance(value, str):
            return value if len(value) <= LONGEST_TEXT and value.isprintable() else None
        case viser.GuiCheckboxHandle(disabled=False) | viser.GuiButtonHandle(disabled=False) if value in [True, False]:
            return bool(value)
    return None


def _is_loopback(host: str) -> bool:
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return False
