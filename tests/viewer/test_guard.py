"""Who reaches the viewer and what they can do to it: real HTTP and raw websockets against a real server."""

import http.client
import socket
import time
from contextlib import closing, contextmanager
from types import SimpleNamespace
from urllib.parse import urlsplit

import msgspec
import numpy as np
import pytest
import viser
import viser.infra._infra as viser_server
import websockets.asyncio.server
import zstandard
from command_line import mrts_without
from conftest import DATA
from shown_viewer import PATIENCE, planar_given, settle, shown_viewer
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

import mrts
from mrts.cli import main
from mrts.viewer.server import LARGEST_MESSAGE, names_this_machine, open_server

PROTOCOL = [f"viser-v{viser.__version__}"]

CAMERA = {"type": "ViewerCameraMessage", "wxyz": [1, 0, 0, 0], "position": [0, 0, 1.5]}
CAMERA |= {"fov": 1, "near": 0.1, "far": 9.0}
CAMERA |= {"image_height": 700, "image_width": 1200, "look_at": [0, 0, 0], "up_direction": [0, 0, 1]}

pack = msgspec.msgpack.encode


@contextmanager
def connected(url, **options):
    """A raw websocket to the viewer's address, as a browser's page opens it."""
    address = url.replace("http", "ws").rstrip("/")
    with connect(address, subprotocols=PROTOCOL, max_size=None, **options) as opened:
        opened.send(pack(CAMERA))
        yield opened


def unpacked(window):
    """What a page unpacks of a message: behind two lengths, its parts, packed together."""
    return zstandard.ZstdDecompressor().decompressobj().decompress(window[16:])


@pytest.fixture(scope="module")
def viewer(planar_cell):
    """A viewer whose steps the test makes, with identifiers of its controls by label."""
    with shown_viewer(planar_given(planar_cell)) as opened:
        opened.uuids = {getattr(handle, "label", ""): uuid for uuid, handle in opened.server.controls.items()}
        yield opened


def update(viewer, label, value):
    return pack({"type": "GuiUpdateMessage", "uuid": viewer.uuids[label], "updates": {"value": value}})


def answer(viewer, path, **headers):
    """Status and text of an answer; a header may be a list."""
    parts = urlsplit(viewer.url)
    with closing(http.client.HTTPConnection(parts.hostname, parts.port, timeout=PATIENCE)) as asked:
        asked.putrequest("GET", path, skip_host=True)
        for name, values in ({"Host": parts.netloc} | headers).items():
            for value in values if isinstance(values, list) else [values]:
                asked.putheader(name, value)
        asked.endheaders()
        got = asked.getresponse()
        return got.status, got.read().decode()


def test_the_page_is_at_the_whole_address_only(viewer):
    path = urlsplit(viewer.url).path
    assert len(viewer.server.token) >= 22  # 128 bits
    status, text = answer(viewer, path)
    assert (status, "<html" in text) == (200, True)
    for wrong in ("/", "/index.html", path[:-2] + "/", path[:-1] + "x/", path.upper(), f"/?token={path}", "//"):
        status, text = answer(viewer, wrong)
        assert (status, path in text) == (403, False), wrong


FOREIGN = {
    "another page": {"Origin": "http://evil.example"},
    "a file": {"Origin": "null"},
    "another port of this machine": {"Origin": "http://127.0.0.1:1"},
    "this address, encrypted": {"Origin": "https://HOST"},
    "two origins": {"Origin": ["http://HOST", "http://evil.example"]},
    "a name that leads here": {"Host": "evil.example", "Origin": "http://evil.example"},
    "a name with our address in it": {"Host": "127.0.0.1.evil.example"},
    "another address of this machine": {"Host": "192.168.0.1"},
    "no host": {"Host": []},
    "two hosts": {"Host": ["HOST", "evil.example"]},
    "no address at all": {"Host": "[::"},
    "a user": {"Host": "127.0.0.1@evil.example"},
}
UPGRADE = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13"}
UPGRADE |= {"Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ=="}


def test_other_pages_and_names_are_refused_even_with_the_token(viewer):
    parts = urlsplit(viewer.url)
    for kind, foreign in FOREIGN.items():
        headers = {
            name: [value.replace("HOST", parts.netloc) for value in ([values] if isinstance(values, str) else values)]
            for name, values in foreign.items()
        }
        for upgrade in ({}, UPGRADE):
            status, text = answer(viewer, parts.path, **headers, **upgrade)
            assert (status, parts.path in text) == (403, False), kind
    for host in ("localhost:9999", "127.0.0.1:9999", "[::1]:9999", "127.0.0.1"):  # a forwarded port
        assert answer(viewer, parts.path, Host=host, Origin=f"http://{host}")[0] == 200, host


def test_whom_an_open_viewer_answers():
    everywhere = "0.0.0.0"  # noqa: S104 (only asked about)
    for listens, host, served in (
        (everywhere, "192.168.0.7:8080", True),
        (everywhere, "evil.example:8080", False),
        ("::", "[fe80::1]:8080", True),
        ("robot.example", "Robot.Example:8080", True),
        ("robot.example", "other.example:8080", False),
    ):
        assert names_this_machine(host, listens) == served, (listens, host)


def test_a_websocket_takes_the_token_and_the_own_page(viewer):
    parts = urlsplit(viewer.url)
    with connected(viewer.url, origin=f"http://{parts.netloc}") as opened:
        assert opened.recv(timeout=PATIENCE)
    for path, origin in (("", None), (parts.path, "http://evil.example")):
        address = f"ws://{parts.netloc}{path}"
        with pytest.raises(InvalidStatus, match="403"), connect(address, subprotocols=PROTOCOL, origin=origin):
            pass


def test_what_is_no_request_is_refused_in_silence(viewer, capfd):
    parts = urlsplit(viewer.url)
    for text in (b"", b"\0garbage\r\n\r\n", b"POST / HTTP/1.1\r\n\r\n", b"GET /" + b"x" * 100_000):
        with socket.create_connection((parts.hostname, parts.port), timeout=PATIENCE) as stranger:
            stranger.sendall(text)
    assert answer(viewer, parts.path)[0] == 200
    assert capfd.readouterr() == ("", "")


BAD = {
    "nothing": b"",
    "garbage": b"\xc1" * 100,
    "text": "hello",
    "half a message": pack(CAMERA)[:-3],
    "no map": pack([1, 2]),
    "no type": pack({"uuid": "x"}),
    "unknown type": pack({"type": "os.system", "command": "true"}),
    "a share tunnel to the internet": pack({"type": "ShareUrlRequest"}),
    "an upload": pack({"type": "FileTransferStartUpload", "transfer_uuid": "x", "part_count": 10**9}),
    "a scene's change": pack({"type": "SceneNodeUpdateMessage", "name": "/object", "updates": {"visible": False}}),
    "a removal": pack({"type": "GuiRemoveMessage", "uuid": "x"}),
    "an unknown control": pack({"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": 1.0}}),
    "nested deeply": b"\x91" * 15_000 + b"\xc0",
    "nested deeply inside": pack({"type": "GuiUpdateMessage", "uuid": "x"})[:-1] + b"\x91" * 9_000 + b"\xc0",
}
BAD_VALUES = {
    "speed c": [float("nan"), float("inf"), -float("inf"), "1", None, [1.0], {}, True, b"\0"],
    "pace": ["", "2", 1, None, True, ["real time"], "x" * 10_000],
    "dark": ["no", 2, None, 0.5, []],
    "Play": ["yes", None, 7, {}],
    "torque rate [1/s]": [5.0],  # is hidden
}


def set_slider(viewer, opened, label, value, shown=None):
    """Send a value of a slider and wait until it is there: a ping is answered before what came ahead of it is read."""
    handle = viewer.controls[label]
    opened.send(update(viewer, label, value))
    shown = value if shown is None else shown
    end = time.monotonic() + PATIENCE
    while handle.value != shown and time.monotonic() < end:
        opened.ping().wait(PATIENCE)
    assert handle.value == shown
    settle(viewer.shown)


def test_what_no_control_can_send_is_ignored(viewer):
    """The connection that sent it, another one, and the viewer go on."""

    def state():
        values = {label: handle.value for label, handle in viewer.controls.items()}
        return values | {"c": viewer.shown.state.trajectory.c}

    before, uuid = state(), viewer.uuids["speed c"]
    others = [{"min": -1e9}, {"disabled": True}, {"removed": True}, {"props": None}, {"sync_cb": None}, {}, None]
    messages = [*BAD.values()]
    messages += [pack({"type": "GuiUpdateMessage", "uuid": uuid, "updates": updates}) for updates in others]
    messages += [update(viewer, label, value) for label, values in BAD_VALUES.items() for value in values]
    with connected(viewer.url) as other, connected(viewer.url) as hostile:
        for message in messages:
            assert viewer.server.checked(message) is None, message[:40]
            hostile.send(message)
        assert hostile.ping().wait(PATIENCE)
        settle(viewer.shown)
        assert state() == before
        set_slider(viewer, hostile, "speed c", 0.5)  # still served
        set_slider(viewer, other, "speed c", before["speed c"])


def test_values_beyond_the_ends_are_the_ends(viewer):
    speeds, before = viewer.shown.state.speeds, viewer.controls["speed c"].value
    with connected(viewer.url) as opened:
        for value, shown in ((1e-300, speeds.lower), (-5, speeds.lower), (1e300, speeds.upper)):
            set_slider(viewer, opened, "speed c", value, shown)
            np.testing.assert_allclose(viewer.shown.state.trajectory.c, shown)
        set_slider(viewer, opened, "speed c", before)
        set_slider(viewer, opened, "time [s]", 1e300, viewer.controls["time [s]"].max)
        assert viewer.shown.sample == len(viewer.shown.state.trajectory.time) - 1


def test_too_large_a_message_ends_its_connection_only(viewer):
    with connected(viewer.url) as other:
        with connected(viewer.url) as hostile:
            hostile.send(b"\0" * (LARGEST_MESSAGE + 1))
            with pytest.raises(ConnectionClosed, match="1009"):
                [hostile.recv(timeout=PATIENCE) for _ in iter(int, 1)]
        set_slider(viewer, other, "speed c", 0.7)


def test_a_viser_that_cannot_be_guarded_is_not_used(monkeypatch):
    """Its internals may change; then no viewer must run unguarded."""
    server = SimpleNamespace(**vars(websockets.asyncio.server))  # no longer where the guard looks
    parts = {name: getattr(viser_server.websockets, name) for name in ("datastructures", "exceptions")}
    monkeypatch.setattr(viser_server, "websockets", SimpleNamespace(asyncio=SimpleNamespace(server=server), **parts))
    with pytest.raises(mrts.InputError, match=r"viser = '.*cannot be guarded"):
        open_server("127.0.0.1", 0, "test")
    assert vars(websockets.asyncio.server)["serve"] is server.serve  # and nothing is left changed


def test_a_wrong_address_is_refused():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        for host, port, match in (
            ("127.0.0.1", taken.getsockname()[1], "--port = .*in use.*any free one"),
            ("no.such.host.invalid", 0, "not a name or address"),
            ("203.0.113.1", 0, "--host = .*cannot be listened at"),
        ):
            with pytest.raises(mrts.InputError, match=match):
                open_server(host, port, "test")


def test_bad_input_and_a_missing_viser_end_before_any_server(tmp_path, capsys):
    assert main(["view", str(tmp_path / "no.yaml"), str(DATA / "lift.yaml")]) == 2
    assert "no.yaml" in capsys.readouterr().err
    done = mrts_without("viser", "view", "no.yaml", "no.yaml")
    assert (done.returncode, "pip install 'mrts[view]'" in done.stderr) == (2, True)
