"""A real browser, without a window or a graphics card, shows what the page is said to show."""

import matplotlib.image
import numpy as np
import pytest
from drawn_plans import LEG, ROBOT, a_plan, a_world, an_estimate

from rfcompass.errors import NoBrowser
from rfcompass.viz import colours
from rfcompass.viz.grasp_view import view
from rfcompass.viz.screenshot import HOW_TO_INSTALL, find_browser, take_picture

SIZE = (900, 600)
in_browser = pytest.mark.skipif(find_browser() is None, reason=HOW_TO_INSTALL)


def pixels(page, folder, at_s=8.0):
    """Red, green, blue in [0, 1], shape (600, 900, 3), of all that the legend does not cover."""
    picture = folder / "page.png"
    take_picture(page, picture, SIZE, at_s)
    shown = matplotlib.image.imread(picture)[:, :, :3]
    assert shown.shape == (SIZE[1], SIZE[0], 3)
    return shown[:, 425:]


def without(page, node):
    """The same page with one box of the legend not ticked."""
    ticked = f'data-node="{node}" checked'
    html = page.read_text(encoding="utf-8")
    assert ticked in html
    bare = page.with_name("bare.html")
    bare.write_text(html.replace(ticked, f'data-node="{node}"'), encoding="utf-8")
    return bare


def near(shown, colour, tolerance=0.25):
    """Which pixels have about the hue of a colour, however bright."""
    direction = colours.rgb(colour) - colours.rgb(colour).mean()
    tint = shown - shown.mean(axis=2, keepdims=True)
    strength = np.linalg.norm(tint, axis=2)
    cosine = tint @ direction / np.maximum(strength * np.linalg.norm(direction), 1e-9)
    return (cosine > 1 - tolerance / 2) & (strength > 0.1)


def differ(one, other):
    """Which pixels are not the same."""
    return np.abs(one - other).max(axis=2) > 0.02


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    drawn = view(ROBOT, an_estimate(), a_plan(), part=LEG, world=a_world())
    return drawn.save(tmp_path_factory.mktemp("grasp") / "grasp.html")


@pytest.fixture(scope="module")
def shown(page, tmp_path_factory):
    """What the page looks like with the part lifted."""
    return pixels(page, tmp_path_factory.mktemp("shown"))


@pytest.mark.slow
@in_browser
@pytest.mark.parametrize(
    ("node", "colour", "least"),
    [
        ("robot", 0xE5590D, 5000),
        ("part", colours.PART, 1000),
        ("belief/cloud", colours.CLOUD, 100),
        ("candidates/kept", colours.SUCCESS_SCALE[-1][1], 50),
    ],
)
def test_what_the_legend_names_is_visible_and_gone_when_unticked(page, shown, tmp_path, node, colour, least):
    hidden = pixels(without(page, node), tmp_path)
    changed = differ(shown, hidden)
    assert (near(shown, colour) & changed).sum() >= least
    assert (near(hidden, colour) & changed).sum() < (near(shown, colour) & changed).sum() / 2


@pytest.mark.slow
@in_browser
def test_the_part_is_lifted(page, tmp_path):
    bare = without(page, "part")
    rows = [
        np.argwhere(differ(pixels(page, tmp_path, at_s), pixels(bare, tmp_path, at_s)))[:, 0].mean()
        for at_s in (5.0, 8.0)
    ]
    assert rows[1] < rows[0] - 20  # rows count downwards


@pytest.mark.slow
@in_browser
def test_equal_pages_look_equal(page, shown, tmp_path):
    assert np.array_equal(pixels(page, tmp_path), shown)


def test_without_a_browser_the_reason_is_told(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("RFCOMPASS_BROWSER", raising=False)
    monkeypatch.setattr("rfcompass.viz.screenshot._BROWSERS", ("chromium",))
    with pytest.raises(NoBrowser, match="no Chromium is installed"):
        take_picture(tmp_path / "page.html", tmp_path / "page.png")


def test_a_browser_that_draws_nothing_is_no_picture(tmp_path, monkeypatch):
    broken = tmp_path / "browser"
    broken.write_text("#!/bin/sh\necho no screen >&2\nexit 1\n")
    broken.chmod(0o755)
    monkeypatch.setenv("RFCOMPASS_BROWSER", str(broken))
    with pytest.raises(NoBrowser) as failure:
        take_picture(tmp_path / "page.html", tmp_path / "page.png")
    assert failure.value.numbers["said"] == "no screen\n"
    assert not (tmp_path / "page.png").exists()
