"""The page in a notebook: JupyterLab in a real browser. `LANDSCAPE_BROWSER` names Chromium, or it is sought."""

import json
import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.request

import pytest

import landscape as ls

CELL = """
import json, pathlib
import landscape as ls
page = ls.explore("lj 7").show(height_px=600)
told = pathlib.Path({told!r})
page.selected = ["m3"]
page.observe(lambda change: told.write_text(json.dumps(change.new)), "selected")
page
"""
CHOSEN = "landscape.state.selected.map(item => landscape.model.name(item)).join()"
#: Seconds that a slow machine may take for one step.
PATIENCE = 40


def test_the_page_is_a_widget():
    pytest.importorskip("anywidget")
    page = ls.explore("muller-brown").show()
    assert page.selected == [] and "postMessage" in page.page and page.page.count("sha256-") >= 3


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    """A running JupyterLab: its address, its folder and its environment."""
    pytest.importorskip("jupyterlab")
    folder = tmp_path_factory.mktemp("lab")
    places = {f"JUPYTER_{name}_DIR": str(folder / name.lower()) for name in ("RUNTIME", "DATA", "CONFIG")}
    environment = {**os.environ, **places, "IPYTHONDIR": str(folder / "ipython")}
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    (folder / "work").mkdir()
    words = [
        sys.executable, "-m", "jupyterlab", "--no-browser", "--allow-root", "--ip=127.0.0.1", f"--port={port}",
        "--ServerApp.port_retries=0", "--IdentityProvider.token=", "--ServerApp.password=", "--LabApp.news_url=",
        "--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate", f"--ServerApp.root_dir={folder / 'work'}",
    ]
    with open(folder / "log", "w") as log:
        server = subprocess.Popen(words, stdout=log, stderr=subprocess.STDOUT, env=environment, start_new_session=True)
    address = f"http://127.0.0.1:{port}"
    try:
        wait(lambda: answers(f"{address}/api"), f"JupyterLab: {folder / 'log'}")
        yield address, folder
    finally:
        server.terminate()
        server.wait(30)


def answers(address):
    try:
        with urllib.request.urlopen(address, timeout=5):
            return True
    except OSError:
        return False


def wait(done, what):
    end = time.monotonic() + PATIENCE
    while not (found := done()):
        assert time.monotonic() < end, f"this did not happen: {what}"
        time.sleep(0.1)
    return found


@pytest.fixture(scope="module")
def browser(run):
    program = os.environ.get("LANDSCAPE_BROWSER") or shutil.which("chromium") or shutil.which("google-chrome")
    if program is None:
        pytest.skip("there is no Chromium, and LANDSCAPE_BROWSER does not name one")
    # Without a sandbox, which a container may not allow; the page is our own.
    started = run.chromium.launch(executable_path=program, args=["--no-sandbox", "--enable-unsafe-swiftshader"])
    yield started
    started.close()


def test_what_is_chosen_on_the_page_comes_back_and_the_other_way(lab, browser, tmp_path):
    address, folder = lab
    told = folder / "selected.json"
    notebook = {
        "cells": [{"cell_type": "code", "id": "show", "source": CELL.format(told=str(told)), "metadata": {}, "outputs": [], "execution_count": None}],
        "metadata": {"kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"}},
        "nbformat": 4, "nbformat_minor": 5,
    }
    (folder / "work/shown.ipynb").write_text(json.dumps(notebook))
    tab = browser.new_page(viewport={"width": 1500, "height": 1000})
    tab.set_default_timeout(1000 * PATIENCE)
    wrong = []
    tab.on("pageerror", lambda error: wrong.append(str(error)))
    tab.goto(f"{address}/doc/tree/shown.ipynb")
    tab.locator(".jp-Notebook .jp-Cell").first.click()
    tab.wait_for_selector("text=/Python 3.*\\| Idle|Idle/", state="attached")
    tab.keyboard.press("Control+Enter")
    shown = tab.locator("iframe[sandbox]").first
    shown.wait_for(state="visible")
    assert shown.bounding_box()["height"] == pytest.approx(602, abs=4)
    shown.content_frame.locator("canvas, svg").first.wait_for(state="visible")
    frame = next(each for each in tab.frames if each.parent_frame is not None and each.url == "about:srcdoc")
    # The page forbids evaluation of text later on, with which the browser's driver would wait for a condition.
    wait(lambda: frame.evaluate("Boolean(globalThis.landscape)"), "the page is there")

    # What was chosen before the page was there.
    wait(lambda: frame.evaluate(CHOSEN) == "m3", "m3 is chosen")

    # From the page to Python: a click on a row of the table.
    shown.content_frame.get_by_role("row").filter(has_text="m2").click()
    wait(lambda: told.is_file() and told.read_text() and json.loads(told.read_text()) == ["m3", "m2"], "m2 is told to Python")
    assert [each.url for each in tab.frames if each.parent_frame is not None] == ["about:srcdoc"]

    # From Python to the page.
    from jupyter_client import BlockingKernelClient

    connection = next((folder / "runtime").glob("kernel-*.json"))
    kernel = BlockingKernelClient(connection_file=str(connection))
    kernel.load_connection_file()
    kernel.start_channels()
    try:
        kernel.wait_for_ready(timeout=PATIENCE)
        kernel.execute_interactive("page.selected = ['m1', 'm3']", timeout=PATIENCE)
        wait(lambda: frame.evaluate(CHOSEN) == "m1,m3", "m1 and m3 are chosen")
        reply = kernel.execute("", user_expressions={"chosen": "page.selected"}, reply=True, timeout=PATIENCE)
        assert reply["content"]["user_expressions"]["chosen"]["data"]["text/plain"] == "['m1', 'm3']"
    finally:
        kernel.stop_channels()
    tab.screenshot(path=tmp_path / "notebook.png")
    assert wrong == []
