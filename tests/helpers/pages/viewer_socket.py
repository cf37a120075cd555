"""A raw websocket to a viewer, as a browser's page opens one: what is sent, and what comes, read."""

from contextlib import contextmanager

import msgspec
import viser
import zstandard
from websockets.sync.client import connect

PROTOCOL = [f"viser-v{viser.__version__}"]

CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": [1, 0, 0, 0],
    "position": [0, 0, 1.5],
    "fov": 1,
    "near": 0.1,
    "far": 9.0,
}
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
