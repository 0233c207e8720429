"""What a page says beside its scene: facts, the stages of a motion, and a legend that shows and hides layers."""

import html
from dataclasses import dataclass

from rfcompass.types.record import Record
from rfcompass.viz.colours import SUCCESS_SCALE, css


@dataclass(frozen=True, slots=True)
class Layer(Record):
    """One row of the legend.

    Attributes:
        name: What it says.
        node: Path of the scene's node that it shows and hides, for example `"candidates/rejected/too_wide"`.
        colour: 0xRRGGBB; None for what has many colours.
        count: How many things of the kind there are, drawn or not; None where nobody counts.
        shown: False if it is hidden until asked for.
    """

    name: str
    node: str
    colour: int | None
    count: int | None = None
    shown: bool = True


@dataclass(frozen=True, slots=True)
class StageMark(Record):
    """A part of a motion that one can jump to.

    Attributes:
        name: What happens.
        start_s: When it begins [s].
    """

    name: str
    start_s: float


@dataclass(frozen=True, slots=True)
class Overlay(Record):
    """What stands beside a scene.

    Attributes:
        title: Heading.
        facts: Rows of name and value.
        layers: Legend, in order.
        stages: Stages of the motion, in order.
        success_scale: True if the scene has the colours of a probability of success.
    """

    title: str
    facts: tuple[tuple[str, str], ...] = ()
    layers: tuple[Layer, ...] = ()
    stages: tuple[StageMark, ...] = ()
    success_scale: bool = False


OVERLAY_STYLE = """
#overlay { position: absolute; left: 0; top: 0; max-width: 24rem; max-height: 96vh; overflow: auto; margin: .6rem;
  padding: .6rem .8rem; background: rgba(255, 255, 255, .88); border-radius: .4rem; color: #1d2733;
  font: 13px/1.45 system-ui, sans-serif; }
#overlay h1 { font-size: 15px; margin: 0 0 .3rem; } #overlay p { margin: .3rem 0; }
#overlay td { padding: 0 .5rem 0 0; vertical-align: top; } #overlay td.count { text-align: right; }
#overlay label { white-space: nowrap; } #overlay input { vertical-align: middle; margin: 0 .3em 0 0; }
#overlay i { display: inline-block; width: .8em; height: .8em; margin-right: .3em; border-radius: .15em; }
#overlay .scale { display: inline-block; width: 7rem; height: .8em; margin: 0 .4em; }
#overlay a { margin-right: .5em; color: #2f5d8a; }
"""

# A time behind the page's address, as in page.html#3.2, stops the motion there; #play plays it.
OVERLAY_SCRIPT = """
for (const box of document.querySelectorAll("#overlay input")) {
  const show = () => {
    viewer.set_property(["meshcat", ...box.dataset.node.split("/")], "visible", box.checked);
    viewer.set_dirty();
  };
  box.addEventListener("change", show);
  show();
}
const go = () => {
  const where = decodeURIComponent(location.hash.slice(1)), time = parseFloat(where), animator = viewer.animator;
  if (where == "play") { animator.reset(); animator.play(); }
  if (!isNaN(time)) { animator.pause(); animator.seek(time); animator.display_progress(time); viewer.set_dirty(); }
};
window.addEventListener("hashchange", go);
go();
"""


def overlay_html(overlay: Overlay) -> str:
    """Lay an overlay out; whatever it says stays text."""
    rows = "".join(f"<tr><td>{_text(name)}</td><td>{_text(value)}</td></tr>" for name, value in overlay.facts)
    parts = [f"<h1>{_text(overlay.title)}</h1>", f"<table>{rows}</table>" if rows else ""]
    if overlay.stages:
        links = "".join(f'<a href="#{stage.start_s:.2f}">{_text(stage.name)}</a>' for stage in overlay.stages)
        parts.append(f'<p><a href="#play">▶ play</a>{links}</p>')
    if overlay.success_scale:
        gradient = ", ".join(css(colour) for _, colour in SUCCESS_SCALE)
        bar = f'<span class="scale" style="background: linear-gradient(90deg, {gradient})"></span>'
        parts.append(f"<p>probability of success 0{bar}1</p>")
    if overlay.layers:
        parts.append(f"<table>{''.join(map(_layer, overlay.layers))}</table>")
    return f'<div id="overlay">{"".join(parts)}</div>'


def _layer(layer: Layer) -> str:
    checked = " checked" if layer.shown else ""
    box = f'<input type="checkbox" data-node="{_text(layer.node)}"{checked}>'
    swatch = "" if layer.colour is None else f'<i style="background: {css(layer.colour)}"></i>'
    count = "" if layer.count is None else str(layer.count)
    return f'<tr><td><label>{box}{swatch}{_text(layer.name)}</label></td><td class="count">{count}</td></tr>'


def _text(value: str) -> str:
    return html.escape(value)
