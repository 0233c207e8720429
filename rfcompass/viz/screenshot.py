"""Pictures of a page, taken by a Chromium that shows no window and needs no graphics card."""

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from rfcompass.errors import NoBrowser

# Names and places of browsers, the smallest first; $RFCOMPASS_BROWSER comes before all of them.
_BROWSERS = (
    "chromium-headless-shell",
    "chrome-headless-shell",
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
)
# WebGL on the processor (SwiftShader). The page is ours, so that it may go without the sandbox, which root cannot have.
_FLAGS = (
    "--headless",
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--hide-scrollbars",
    "--no-first-run",
    "--disable-dev-shm-usage",
    "--virtual-time-budget=3000",  # [ms] of the page's own time: it has drawn by then
)
_PATIENCE_S = 120.0
HOW_TO_INSTALL = "no Chromium is installed: apt-get install chromium-headless-shell"


def find_browser() -> Path | None:
    """Find a Chromium: `$RFCOMPASS_BROWSER`, or the first that is installed; None if there is none."""
    for name in (os.environ.get("RFCOMPASS_BROWSER", ""), *_BROWSERS):
        if name and (found := shutil.which(name)) is not None:
            return Path(found)
    return None


def take_picture(page: Path, picture: Path, size: tuple[int, int] = (1200, 800), at_s: float | None = None) -> None:
    """Write a PNG of a page.

    Args:
        page: HTML file.
        picture: PNG to write.
        size: Width and height [pixels].
        at_s: Moment of the page's motion [s]; None to let it begin to play.

    Raises:
        NoBrowser: If no Chromium is installed, or it drew nothing; carries what it said.
    """
    browser = find_browser()
    if browser is None:
        raise NoBrowser(
            "no Chromium is installed (`apt-get install chromium-headless-shell`), or set $RFCOMPASS_BROWSER"
        )
    address = page.resolve().as_uri() + ("" if at_s is None else f"#{at_s:.3f}")
    with tempfile.TemporaryDirectory() as folder:
        drawn = Path(folder) / "page.png"
        asked = [f"--user-data-dir={folder}", f"--window-size={size[0]},{size[1]}", f"--screenshot={drawn}", address]
        told = subprocess.run(  # noqa: S603 - a browser that the user has installed
            [str(browser), *_FLAGS, *asked], capture_output=True, text=True, timeout=_PATIENCE_S, check=False
        )
        if told.returncode or not drawn.is_file():
            raise NoBrowser(f"{browser} drew nothing of {page}", browser=str(browser), said=told.stderr[-2000:])
        shutil.copyfile(drawn, picture)
