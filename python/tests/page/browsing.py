"""A folder in which the program runs, and its pages in a real browser, which Playwright drives."""

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

sync_api = pytest.importorskip("playwright.sync_api")

PERSON = (Path(__file__).parent / "person.js").read_text()
#: The program that cargo built, or the command line of this package.
PROGRAM = [os.environ["LANDSCAPE_PROGRAM"]] if "LANDSCAPE_PROGRAM" in os.environ else [sys.executable, "-c", "import sys, landscape; sys.exit(landscape.main())"]
#: Seconds that a slow machine may take for one step.
PATIENCE = 60
#: Without a sandbox, which a container may not allow; three dimensions in software.
FLAGS = ["--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader"]


class Desk:
    """A folder in which the whole program runs."""

    def __init__(self, folder):
        self.folder = folder

    def run(self, *words):
        return subprocess.run([*PROGRAM, *map(str, words)], cwd=self.folder, capture_output=True, text=True)

    def succeed(self, *words):
        done = self.run(*words)
        assert done.returncode == 0, done.stderr
        return done.stderr


class Tab:
    """A page in a browser. It must cause no error, no warning, no request, and no breach of its policy."""

    def __init__(self, tab, folder):
        self.tab, self.folder, self.mishaps = tab, folder, []
        tab.set_default_timeout(1000 * PATIENCE)
        tab.on("pageerror", lambda error: self.mishaps.append(f"error: {error}"))
        tab.on("console", self.heard)
        tab.on("request", lambda request: self.asked(request.url))

    def heard(self, message):
        # The driver of software rendering warns that it is slow.
        if message.type in ("error", "warning", "assert") and "GL Driver Message" not in message.text:
            self.mishaps.append(f"{message.type}: {message.text}")

    def asked(self, url):
        if not url.startswith(("file:", "blob:", "data:", "about:")):
            self.mishaps.append(f"request: {url}")

    def open(self, page, fragment=""):
        # A fragment alone would not load the page again.
        self.tab.goto("about:blank")
        self.tab.goto(f"{(self.folder / page).as_uri()}#{fragment}")
        self.until("document.body?.dataset.ready === '1'")
        return self

    def reload(self):
        self.tab.reload()
        self.until("document.body?.dataset.ready === '1'")

    def value(self, expression):
        """The value of an expression, which may use the names of `person.js`."""
        return self.act(f"return ({expression});")

    def act(self, script, given=None):
        """What a script returns, which may use the names of `person.js` and what is `given`."""
        return self.tab.evaluate(f"async given => {{ {PERSON}\n{script} }}", given)

    def until(self, expression):
        """Waits until an expression is true. The policy of the page forbids the browser's driver to do so."""
        end = time.monotonic() + PATIENCE
        while not self.tab.evaluate(f"() => Boolean({expression})"):
            assert time.monotonic() < end, f"never true: {expression}"
            time.sleep(0.03)

    def settle(self):
        self.tab.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))")

    def saved(self, button):
        """The bytes of the file that a press of this button saves, and its name."""
        with self.tab.expect_download() as download:
            self.tab.evaluate("id => document.getElementById(id).click()", button)
        return Path(download.value.path()).read_bytes(), download.value.suggested_filename


def chromium(run, *flags):
    program = os.environ.get("LANDSCAPE_BROWSER") or next(filter(None, map(shutil.which, ("chromium", "google-chrome"))), None)
    if program is None:
        pytest.skip("there is no Chromium, and LANDSCAPE_BROWSER does not name one")
    return run.chromium.launch(executable_path=program, args=[*FLAGS, *flags])


def firefox(run):
    """Firefox of Playwright (`playwright install firefox`), else that of the system, which must speak WebDriver BiDi well enough."""
    system = os.environ.get("LANDSCAPE_FIREFOX") or shutil.which("firefox-esr") or shutil.which("firefox")
    choices = [{}] + ([{"channel": "moz-firefox", "executable_path": system}] if system else [])
    for choice in choices:
        try:
            return run.firefox.launch(**choice)
        except sync_api.Error:
            pass
    pytest.skip("there is no Firefox that Playwright can drive")


def says(sentence, *words):
    missing = [word for word in words if word not in sentence]
    assert missing == [], sentence
