"""The same walk through the page, with a mouse and a keyboard as a person has them, in each browser."""

import json

import pytest
from playwright.sync_api import Error

from browsing import chromium, firefox, says

STATE = "JSON.stringify({ ...state, hover: null, look: 0, labels: 0 })"


def leaf(tab, item):
    """Where a leaf of the tree is in the window."""
    return tab.act("""
scrollTo(0, 0);
const box = panels.tree.drawing.canvas.getBoundingClientRect();
const [x, y] = panels.tree.at(given);
return [box.left + x, box.top + y];
""", item)


def part_of(tab, selector, across, down):
    """A place in an element, as parts of its width and height."""
    element = tab.tab.locator(selector)
    element.evaluate("element => element.scrollIntoView({ block: 'center' })")
    box = element.bounding_box()
    return [box["x"] + across * box["width"], box["y"] + down * box["height"]]


def drag(tab, first, *places):
    mouse = tab.tab.mouse
    mouse.move(*first)
    mouse.down()
    for place in places:
        mouse.move(*place)
    mouse.up()
    tab.settle()


def walk(tab, solid):
    """Hover, choice, level, pins, search and scrubber, and the same state after a reload."""
    mouse, keyboard = tab.tab.mouse, tab.tab.keyboard
    x, y = leaf(tab, 5)
    mouse.move(x + 40, y + 40)
    mouse.move(x, y)
    tab.settle()
    told = tab.value("[state.hover, byId('tip').textContent.slice(0, 2), document.querySelector('.row.hover')?.dataset.item]")
    assert told == [5, "m5", "5"]
    if solid:
        tab.until("document.querySelector('#scene .caption').textContent.startsWith('m5 ')")
        there = "landscape.model.coordinates(5).every((value, k) => Math.abs(value - landscape.panels.scene.views[0].x[k]) < 1e-6)"
        tab.until(there)

    mouse.move(*leaf(tab, 9))
    keyboard.press("p")
    assert tab.value("state.pins") == ([9] if solid else [])

    for item in (3, 17):
        mouse.click(*leaf(tab, item))
    tab.settle()
    assert tab.value("state.selected") == [3, 17]
    says(tab.value("document.querySelector('#way .words').textContent"), "From m3 to m17", "pass")

    across, down = part_of(tab, ".level", 0.5, 0.5)
    wanted = tab.value("panels.tree.drawing.canvas.getBoundingClientRect().top + panels.tree.y((panels.tree.low + panels.tree.top) / 2)")
    drag(tab, [across, down], [across, (down + wanted) / 2], [across, wanted])
    off = tab.value("(state.level - (panels.tree.low + panels.tree.top) / 2) / (panels.tree.top - panels.tree.low)")
    assert abs(off) < 0.02
    assert tab.value("derived.basins.list.length") > 0

    mouse.click(*part_of(tab, "#query", 0.3, 0.5))
    keyboard.type("m17")
    tab.settle()
    assert tab.value("[state.query, derived.passing, byId('answer').textContent]") == ["m17", 1, "1 of 60"]

    drag(tab, *(part_of(tab, "#way input", share, 0.5) for share in (0.02, 0.25, 0.5)))
    assert 0.4 < tab.value("state.step") < 0.6

    before = tab.value(STATE)
    # The address is written a moment after the last change. An earlier moment of the same drag may stand in it until then.
    tab.until("new URLSearchParams(location.hash.slice(1)).get('step') === String(Number(landscape.state.step.toFixed(4)))")
    # What a fragment holds has fewer digits, so the state is compared after two readings.
    tab.reload()
    once = tab.value(STATE)
    tab.reload()
    assert tab.value(STATE) == once
    assert rounded(before) == rounded(once)


def rounded(text):
    """A state with its numbers to four digits."""
    state = json.loads(text)
    return {**state, **{name: f"{state[name]:.3e}" for name in ("level", "step")}}


def test_a_person_explores_in_chromium(explored, opened):
    walk(opened(explored / "g.report.html"), True)


def test_a_person_explores_without_three_dimensions(explored, run, opened):
    """Where three dimensions are missing, everything else works, and a sentence says so."""
    flat = chromium(run, "--disable-3d-apis")
    tab = opened(explored / "g.report.html", browser=flat)
    says(tab.value("document.querySelector('#scene .alone').textContent"), "cannot draw in three dimensions", "work without it")
    walk(tab, False)


@pytest.fixture
def other(run):
    started = firefox(run)
    try:
        started.new_context().close()
    except Error as error:
        pytest.skip(f"this Firefox does not understand this Playwright: {error}".splitlines()[0])
    yield started
    started.close()


def test_a_person_explores_in_firefox(explored, other, opened):
    """A smoke test in the other family of browsers. Its rendering may lack three dimensions, where the machine does."""
    tab = opened(explored / "g.report.html", browser=other)
    walk(tab, tab.value("Boolean(panels.scene.views)"))
