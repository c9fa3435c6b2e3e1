"""What the page is for everyone: contrast, colours for all kinds of colour blindness, a visible focus, no motion where none is wanted."""

import itertools

import numpy as np

from browsing import says

#: Finds texts whose contrast with what is behind them is below that of WCAG AA. Colours are composed on a canvas, as the
#: browser composes them, so that no form of colour need be understood here.
AUDIT = r"""
const canvas = document.createElement("canvas");
canvas.width = canvas.height = 1;
const pen = canvas.getContext("2d", { willReadFrequently: true });
const painted = colours => {
  for (const colour of ["#fff", ...colours]) { pen.fillStyle = colour; pen.fillRect(0, 0, 1, 1); }
  return [...pen.getImageData(0, 0, 1, 1).data].slice(0, 3);
};
const light = channels => {
  const [r, g, b] = channels.map(c => ((c /= 255) <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4));
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
};
const contrast = (a, b) => { const [p, q] = [light(a) + 0.05, light(b) + 0.05]; return Math.max(p, q) / Math.min(p, q); };
const pale = [];
let texts = 0;
const audit = where => {
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const text = walker.currentNode.textContent.trim();
    const element = walker.currentNode.parentElement;
    if (!text || element.closest("script, style, noscript, option") || !element.checkVisibility({ visibilityProperty: true })) continue;
    const behind = [];
    for (let at = element; at; at = at.parentElement) behind.unshift(getComputedStyle(at).backgroundColor);
    const { color, fontSize, fontWeight } = getComputedStyle(element);
    const [size, bold] = [parseFloat(fontSize), fontWeight >= 700];
    const ratio = contrast(painted(behind), painted([...behind, color]));
    texts++;
    if (ratio < (size >= 24 || (bold && size >= 18.66) ? 3 : 4.5)) pale.push(`${where}: “${text.slice(0, 40)}” ${ratio.toFixed(2)}`);
  }
};
const schemes = [];
for (const scheme of ["light", "dark"]) {
  if ((look.dark ? "dark" : "light") !== scheme) byId("theme").click();
  await settled();
  audit(scheme);
  change({ level: 0.2, query: "energy <", pins: [1, 2] });
  await settled();
  audit(scheme + ", level");
  change({ level: null, query: "m", pins: [] });
  byId("export-open").click();
  audit(scheme + ", export");
  byId("export").close();
  byId("help-open").click();
  audit(scheme + ", help");
  byId("help").close();
  panels.label.open();
  panels.label.give("Tripod");
  panels.label.choose("");
  audit(scheme + ", labels");
  byId("chooser").close();
  panels.label.close();
  await point(panels.tree.drawing.canvas, "pointermove", panels.tree.at(5));
  audit(scheme + ", tip");
  await point(panels.tree.drawing.canvas, "pointerleave", [0, 0]);
  const own = name => painted([look[name]]);
  schemes.push({
    scheme,
    texts: ["ink", "soft"].map(name => contrast(own(name), own("paper"))),
    marks: ["line", "pale", "route", "accent"].map(name => [name, contrast(own(name), own("paper"))]),
    families: FAMILY[scheme].map(colour => [colour, contrast(painted([colour]), own("paper"))]),
    ground: contrast(own("accent"), painted([getComputedStyle(document.body).backgroundColor])),
    colours: FAMILY[scheme].map(colour => painted([colour])),
    others: ["line", "pale", "route"].map(own),
  });
}
return { pale, texts, schemes };
"""

#: Full protanopia, deuteranopia and tritanopia in linear RGB. Source: Machado, Oliveira and Fernandes (2009),
#: doi:10.1109/TVCG.2009.113, severity 1.
BLINDNESS = [
    np.eye(3),
    [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
]
#: Oklab, where black and white are 1 apart: Ottosson (2020).
CONES = [[0.4122214708, 0.5363325363, 0.0514459929], [0.2119034982, 0.6806995451, 0.1073969566], [0.0883024619, 0.2817188376, 0.6299787005]]
LAB = [[0.2104542553, 0.793617785, -0.0040720468], [1.9779984951, -2.428592205, 0.4505937099], [0.0259040371, 0.7827717662, -0.808675766]]


def distance(*colours):
    """Least distance of two colours over normal sight and three kinds of colour blindness."""
    channels = np.array(colours).T / 255
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    seen = [np.array(LAB) @ np.cbrt(np.array(CONES) @ np.clip(np.array(sight) @ linear, 0, 1)) for sight in BLINDNESS]
    return min(np.linalg.norm(one[:, 0] - one[:, 1]) for one in seen)


def test_everything_can_be_seen_in_light_and_dark(explored, opened):
    told = opened(explored / "g.report.html", "sel=m3,m17").act(AUDIT)
    assert told["pale"] == []
    assert told["texts"] > 2000, "all states were looked at"
    assert [scheme["scheme"] for scheme in told["schemes"]] == ["light", "dark"]
    for scheme in told["schemes"]:
        # Texts and marks on canvases, and the ring of the focus on the ground of the page.
        assert min(scheme["texts"]) >= 4.5
        assert min(ratio for _, ratio in scheme["marks"] + scheme["families"]) >= 3
        assert scheme["ground"] >= 3
        families = scheme["colours"]
        assert min(itertools.starmap(distance, itertools.combinations(families, 2))) > 0.09
        assert min(itertools.starmap(distance, itertools.product(families, scheme["others"]))) > 0.08


FOCUSED = """
const at = document.activeElement;
if (at === document.body) return null;
const { outlineStyle, outlineWidth } = getComputedStyle(at);
const box = at.getBoundingClientRect();
return { name: at.id || at.className || at.tagName, ring: outlineStyle !== "none" && parseFloat(outlineWidth) >= 2,
         inside: box.bottom > 0 && box.top < innerHeight };
"""


def test_the_focus_is_visible(explored, opened):
    """Whoever goes through the page by the Tab key sees where he is."""
    tab = opened(explored / "g.report.html", "sel=m3,m17&pin=m3")
    stops = set()
    for _ in range(200):
        tab.tab.keyboard.press("Tab")
        at = tab.act(FOCUSED)
        if at is None:
            break
        assert at["ring"] and at["inside"], at
        stops.add(at["name"])
    says(" ".join(sorted(stops)), "query", "colour", "label-start", "export-open", "help-open", "theme", "level", "CANVAS", "scroll", "chip",
         "SUMMARY", "INPUT")


def test_nothing_moves_where_no_motion_is_wanted(explored, opened):
    """Where no motion is wanted, a hand is at once where it is to be; else it glides."""
    for motion, still in (("reduce", True), ("no-preference", False)):
        tab = opened(explored / "g.report.html", reduced_motion=motion)
        # On a busy machine a frame may take longer than the motion, so motion is looked for several times.
        for item in range(30, 36):
            told = tab.act("""
change({ hover: given });
await new Promise(requestAnimationFrame);
await null;
const view = panels.scene.views[0];
return [view.gliding !== 0, view.x.every((value, k) => value === model.coordinates(given)[k]), document.getAnimations().length];
""", item)
            if told[0] != still:
                break
        assert told == [not still, still, 0]
