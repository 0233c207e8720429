"""A scene on a meshcat server: a page in a browser that follows what is drawn."""

import contextlib
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import meshcat

from rfcompass.viz.meshcat_page import RecordingWindow


@dataclass(frozen=True, slots=True)
class LiveView:
    """A running meshcat server; it ends with this process, or before that with `close`.

    Attributes:
        url: Address of its page, on this machine.
        visualizer: meshcat's own handle, to draw more or to move what is drawn.
    """

    url: str
    visualizer: "meshcat.Visualizer"

    def wait(self) -> None:
        """Serve until Ctrl-C, then end the server."""
        sys.stderr.write("Ctrl-C ends the live view\n")
        with contextlib.suppress(KeyboardInterrupt):
            self.visualizer.window.server_proc.wait()
        self.close()

    def close(self) -> None:
        """End the server."""
        window = self.visualizer.window
        window.zmq_socket.close(linger=0)
        window.server_proc.kill()
        window.server_proc.communicate()


@dataclass(frozen=True, slots=True)
class _Kept:
    """A command that was recorded, for sending again."""

    data: Mapping[str, Any]

    def lower(self) -> Mapping[str, Any]:
        """Return the command as plain data."""
        return self.data


def show_live(window: RecordingWindow, *, open_browser: bool = True) -> LiveView:
    """Start a meshcat server and draw on it everything that a window has kept.

    Args:
        window: What to show.
        open_browser: Open the page; without, whoever wants to look goes to the address.
    """
    with contextlib.redirect_stdout(sys.stderr):  # meshcat prints its address, and stdout may be somebody's JSON
        visualizer = meshcat.Visualizer()
    for command in window.commands:
        visualizer.window.send(_Kept(command))
    if open_browser:
        visualizer.open()
    return LiveView(visualizer.url(), visualizer)


def follow(window: RecordingWindow, *, open_browser: bool = True) -> LiveView:
    """Show a window live, and everything that is drawn into it from now on.

    Args:
        window: What to show.
        open_browser: Open the page.
    """
    live = show_live(window, open_browser=open_browser)
    window.forward = lambda command: live.visualizer.window.send(_Kept(command))
    return live
