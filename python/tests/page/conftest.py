"""Pages of `landscape report`, opened in browsers."""

import pytest

import made
from browsing import Desk, Tab, chromium


@pytest.fixture(scope="session")
def browser(run):
    started = chromium(run)
    yield started
    started.close()


@pytest.fixture
def desk(tmp_path):
    return Desk(tmp_path)


@pytest.fixture(scope="session")
def explored(tmp_path_factory):
    """A folder with the page of a landscape of 60 minima in 6 families."""
    desk = Desk(tmp_path_factory.mktemp("explored"))
    made.landscape(desk.folder / "g.landscape", 60, 6)
    desk.succeed("report", "g.landscape", "-q")
    return desk.folder


@pytest.fixture
def opened(browser):
    """Opens pages, each in a context of its own, and looks for mishaps at the end."""
    tabs = []

    def open(page, fragment="", browser=browser, **options):
        context = browser.new_context(viewport={"width": 1440, "height": 1000}, **options)
        tabs.append((context, tab := Tab(context.new_page(), page.parent)))
        return tab.open(page.name, fragment)

    yield open
    for context, tab in tabs:
        context.close()
        assert tab.mishaps == []
