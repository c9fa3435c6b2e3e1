"""The page of ``landscape report`` as a widget of a notebook."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import traitlets

from ._call import Folder

if TYPE_CHECKING:

    class AnyWidget:
        """What is used of ``anywidget.AnyWidget``, whose types are not known to type checkers."""

        def __init__(self, **traits: Any) -> None: ...
        def observe(self, handler: Callable[[Any], object], names: str | list[str] = ...) -> None: ...
        def unobserve(self, handler: Callable[[Any], object], names: str | list[str] = ...) -> None: ...
        def close(self) -> None: ...
else:
    from anywidget import AnyWidget

#: Runs in the page: tells the notebook what is selected, and selects what the notebook tells.
_BRIDGE = """
{
  let told = "";
  setInterval(() => {
    if (!model) return;
    const names = state.selected.map(item => model.name(item));
    if (names.join() !== told) {
      told = names.join();
      parent.postMessage({ landscape: names }, "*");
    }
  }, 100);
  window.addEventListener("message", event => {
    if (event.source !== parent || !Array.isArray(event.data?.landscape) || !model) return;
    const items = event.data.landscape.map(name => model.named(name)).filter(item => item !== null);
    told = event.data.landscape.join();
    change({ selected: items.slice(0, 2) });
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
    const heard = event => {
      if (event.source !== frame.contentWindow || !Array.isArray(event.data?.landscape)) return;
      model.set("selected", event.data.landscape);
      model.save_changes();
    };
    const told = () => frame.contentWindow?.postMessage({ landscape: model.get("selected") }, "*");
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
        raise RuntimeError("the page has another form than this version of the widget knows")
    place = allowed.rindex("</body>")
    return f"{allowed[:place]}<script>{_BRIDGE}</script>{allowed[place:]}"


class Page(AnyWidget):
    """A page that is shown in a notebook. ``selected`` are the names of the items chosen on it, the latest last; setting it
    chooses them."""

    _esm = _ESM
    page: traitlets.Unicode[str, str | bytes] = traitlets.Unicode().tag(sync=True)
    height_px: traitlets.Int[int, int] = traitlets.Int(720).tag(sync=True)
    selected: traitlets.List[str] = traitlets.List(traitlets.Unicode()).tag(sync=True)

    @classmethod
    def of(cls, write: Callable[..., Path], height_px: int) -> Page:
        """The page that ``write`` writes into the file that it is given."""
        folder = Folder()
        text = write(folder / "page.html", progress=False).read_text(encoding="utf-8")
        return cls(page=bridged(text), height_px=height_px)
