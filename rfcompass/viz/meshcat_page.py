"""A meshcat scene as one HTML file, without a server, a port or a browser.

meshcat's own `static_html` asks a running server for the scene and names objects by the clock. A recording
window stands in for the server: it takes the same commands, numbers the objects in order, and writes the same
page, so that equal scenes give equal bytes.
"""

import base64
import html
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Protocol

import meshcat
import umsgpack
from meshcat.servers.zmqserver import VIEWER_ROOT

from rfcompass.files import write_text_atomic
from rfcompass.viz.overlay import OVERLAY_SCRIPT, OVERLAY_STYLE, Overlay, overlay_html

_PAGE = """<!doctype html>
<html lang="en">
<head><meta charset="utf-8"><title>{title}</title>
<style>body {{ margin: 0; }} #meshcat-pane {{ width: 100vw; height: 100vh; overflow: hidden; }}{style}</style></head>
<body><div id="meshcat-pane"></div>{overlay}
<script>{viewer}</script>
<script>
var viewer = new MeshCat.Viewer(document.getElementById("meshcat-pane"));
for (const command of {commands}) {{
  viewer.handle_command_bytearray(Uint8Array.from(atob(command), c => c.charCodeAt(0)));
}}
{script}
</script></body></html>
"""


class Command(Protocol):
    """What meshcat's commands have in common."""

    def lower(self) -> dict[str, Any]:
        """Return the command as plain data."""
        ...


class RecordingWindow:
    """Takes meshcat's commands and keeps them."""

    def __init__(self) -> None:
        """Start with an empty scene."""
        self.commands: list[dict[str, Any]] = []
        self.forward: Callable[[dict[str, Any]], object] | None = None  # who else gets every command from now on
        self._names: dict[str, str] = {}

    def send(self, command: Command) -> None:
        """Keep one command, with its object names replaced by numbers in order of appearance."""
        data = command.lower()
        if data["type"] == "set_animation":  # the viewer forgets the one before
            self.commands = [kept for kept in self.commands if kept["type"] != "set_animation"]
        self._number(data)
        self.commands.append(self._renamed(data))
        if self.forward is not None:
            self.forward(self.commands[-1])

    def visualizer(self) -> "meshcat.Visualizer":
        """Return a meshcat visualizer that draws into this window."""
        return meshcat.Visualizer(window=self)

    def _number(self, data: Any) -> None:  # noqa: ANN401 - plain data of any shape
        if isinstance(data, Mapping):
            if "uuid" in data:
                self._names.setdefault(data["uuid"], f"object-{len(self._names)}")
            for value in data.values():
                self._number(value)
        elif isinstance(data, list):
            for item in data:
                self._number(item)

    def _renamed(self, data: Any) -> Any:  # noqa: ANN401 - plain data of any shape
        if isinstance(data, Mapping):
            return {key: self._renamed(value) for key, value in data.items()}
        if isinstance(data, list):
            return [self._renamed(item) for item in data]
        return self._names.get(data, data) if isinstance(data, str) else data


def scene_html(window: RecordingWindow, title: str, overlay: Overlay | None = None) -> str:
    """Return the page that shows everything drawn into `window`; it needs no other file or address.

    A time behind the page's address, as in `page.html#3.2`, opens it with the motion stopped there.

    Args:
        window: What was drawn.
        title: Title of the page.
        overlay: What to say beside the scene; nothing if None.
    """
    packed = [base64.b64encode(umsgpack.packb(command)).decode() for command in window.commands]
    viewer = (Path(VIEWER_ROOT) / "main.min.js").read_text(encoding="utf-8")
    return _PAGE.format(
        title=html.escape(title),
        viewer=viewer,
        commands=packed,
        style=OVERLAY_STYLE,
        overlay="" if overlay is None else overlay_html(overlay),
        script=OVERLAY_SCRIPT,
    )


def write_scene(path: Path, window: RecordingWindow, title: str, overlay: Overlay | None = None) -> None:
    """Write the page atomically; arguments as for `scene_html`."""
    write_text_atomic(path, scene_html(window, title, overlay))
