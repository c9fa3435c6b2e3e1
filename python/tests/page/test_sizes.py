"""Sizes and times of pages of large landscapes."""

import time

import pytest

import made

#: How often times are measured at most.
TRIES = 25
#: Greatest time from a movement of the mouse to the hand in its new pose on the screen, milliseconds.
HOVER_MS = 1000
#: Notes when the page could be used: it was ready, and two frames were painted since.
CLOCK = """addEventListener("ready", () => requestAnimationFrame(() => requestAnimationFrame(() => { window.usable = performance.now(); })), true);"""
#: Moves the mouse over leaves of the tree and waits until the pose is painted; reading a pixel waits for the renderer. The best of
#: seven.
HOVER = """
const times = [];
const view = panels.scene.views[0];
const gl = view.renderer.getContext();
const { canvas } = panels.tree.drawing;
const pixel = new Uint8Array(4);
for (const item of [2, 7, 11, 3, 19, 23, 31]) {
  const box = canvas.getBoundingClientRect();
  const [x, y] = panels.tree.at(item);
  await wait(50);
  const begun = performance.now();
  canvas.dispatchEvent(new PointerEvent("pointermove", { clientX: box.left + x, clientY: box.top + y, bubbles: true }));
  await new Promise(requestAnimationFrame);
  gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
  if (view.x.every((value, k) => value === model.coordinates(state.hover)[k])) times.push(performance.now() - begun);
}
return Math.min(1e9, ...times);
"""


@pytest.mark.parametrize(("count", "families", "most", "usable_ms"), [(400, 40, 2_400_000, 10_000), (10_000, 300, 7_900_000, 30_000)])
def test_a_page_is_small_and_quick(count, families, most, usable_ms, desk, opened):
    """The page of a landscape of so many minima is at most `most` bytes, the same again, and usable soon."""
    made.landscape(desk.folder / "g.landscape", count, families)
    desk.succeed("report", "g.landscape", "-q")
    page = (desk.folder / "g.report.html").read_bytes()
    print(f"{count} minima: {1e-6 * len(page):.2f} MB")
    assert len(page) <= most
    if count < 1000:
        desk.succeed("report", "g.landscape", "-q", "-o", "again.html")
        assert (desk.folder / "again.html").read_bytes() == page
    told = opened(desk.folder / "g.report.html").act("""
const gaps = [];
for (const item of [1, 5, 9, 13]) {
  change({ hover: item });
  await wait(600);
  gaps.push(panels.scene.views[0].x[0] - model.coordinates(item)[0]);
}
return { count: model.count, off: Math.max(...gaps.map(Math.abs)), rows: document.querySelectorAll("#table .rows .row").length,
         circles: model.sides[0].graph.x.length };
""")
    assert told["count"] == count and told["off"] < 1e-6 and told["rows"] < 60
    assert told["circles"] == (families if count > 500 else count)
    quick(opened(desk.folder / "g.report.html", reduced_motion="reduce"), usable_ms)


def quick(tab, usable_ms):
    """Measures in real time, in software rendering, from the start of the navigation.

    Tests of this project assert no times, because a machine may be busy with something else. The limits are therefore ten times
    what a quiet machine takes, and the best of several tries counts: only a page that hangs fails. No motion is wanted, because a
    glide takes its time on purpose.
    """
    tab.tab.add_init_script(CLOCK)
    best = [float("inf")] * 2
    for _ in range(TRIES):
        tab.reload()
        tab.until("window.usable")
        best = [min(pair) for pair in zip(best, (tab.value("window.usable"), tab.act(HOVER)))]
        print(f"usable after {best[0]:.0f} ms, hover {best[1]:.0f} ms")
        if best[0] < usable_ms and best[1] < HOVER_MS:
            return
        time.sleep(0.5)
    pytest.fail(f"usable after {best[0]:.0f} ms, a new pose after {best[1]:.0f} ms in the best of {TRIES} tries")
