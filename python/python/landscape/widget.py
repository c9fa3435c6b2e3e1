"""The page of ``landscape report`` as a widget of a notebook."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import traitlets

from ._call import Folder

if TYPE_CHECKING:

    class AnyWidget(traitlets.HasTraits):
        """What is used of ``anywidget.AnyWidget``, whose types are not known to type checkers."""

        def close(self) -> None: ...
else:
    from anywidget import AnyWidget

#: Runs in the page: tells the notebook when it is ready and what is selected, and selects what the notebook tells.
_BRIDGE = """
{
  let told = "";
  let page = null;
  setInterval(() => {
    if (!page) {
      page = globalThis.landscape;
      if (page) parent.postMessage({ landscape: "ready" }, "*");
      return;
    }
    const names = page.state.selected.map(item => page.model.name(item));
    if (names.join() !== told) {
      told = names.join();
      parent.postMessage({ landscape: names }, "*");
    }
  }, 100);
  window.addEventListener("message", event => {
    if (event.source !== parent || !Array.isArray(event.data?.landscape) || !page) return;
    const items = event.data.landscape.map(name => page.model.named(name)).filter(item => item !== null);
    told = event.data.landscape.join();
    page.change({ selected: items.slice(0, 2) });
  });
}
"""

_ESM = """
export default {
  render({ model, el }) {
    const frame = document.createElement("iframe");
    frame.setAttribute("sandbox", "allow-scripts allow-downloads");
    frame.style.cssText = `width: 100%; height: ${model.get("height_px")}px; border: 1px solid #ccc`;
    frame.srcdoc = model.get("page");
    el.appendChild(frame);
    const told = () => frame.contentWindow?.postMessage({ landscape: model.get("selected") }, "*");
    const heard = event => {
      if (event.source !== frame.contentWindow) return;
      // What was selected before the page was there.
      if (event.data?.landscape === "ready" && model.get("selected").length > 0) told();
      if (!Array.isArray(event.data?.landscape)) return;
      model.set("selected", event.data.landscape);
      model.save_changes();
    };
    window.addEventListener("message", heard);
    model.on("change:selected", told);
    return () => {
      window.removeEventListener("message", heard);
      model.off("change:selected", told);
    };
  },
};
"""


def bridged(page: str) -> str:
    """The page with a script that exchanges the selection, which its policy of contents allows by the hash."""
    digest = base64.b64encode(hashlib.sha256(_BRIDGE.encode()).digest()).decode()
    allowed, count = re.subn(r"(script-src )", rf"\1'sha256-{digest}' ", page, count=1)
    if count != 1 or "</body>" not in allowed:
        raise RuntimeError("the page has a form that this version of the widget does not support")
    place = allowed.rindex("</body>")
    return f"{allowed[:place]}<script>{_BRIDGE}</script>{allowed[place:]}"


class Page(AnyWidget):
    """A page that is shown in a notebook: what :meth:`Landscape.show` and :meth:`Grasps.show` return."""

    _esm = _ESM
    page: traitlets.Unicode[str, str | bytes] = traitlets.Unicode().tag(sync=True)
    """The page (HTML)."""
    height_px: traitlets.Int[int, int] = traitlets.Int(720).tag(sync=True)
    """Its height on the screen, pixels."""
    selected: traitlets.List[str] = traitlets.List(traitlets.Unicode()).tag(sync=True)
    """Names of the items chosen on it, such as ``"m0"``, the latest last. Setting it chooses them, also before the page is
    there."""

    @classmethod
    def of(cls, write: Callable[..., Path], height_px: int) -> Page:
        """The page that ``write`` writes into the file that it is given, ``height_px`` pixels high."""
        folder = Folder()
        text = write(folder / "page.html", progress=False).read_text(encoding="utf-8")
        return cls(page=bridged(text), height_px=height_px)
