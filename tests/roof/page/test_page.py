"""The page in a browser without a window, as `drakesep ui` serves it.

With `-m browser`; machines without NiceGUI or Chromium skip it.
"""

import contextlib
import http.client
import os
import signal
import socket
from pathlib import Path

import pytest
from browser import browser
from served import READY, opened, served
from small_case import small_case, write_case


pytest.importorskip("nicegui")
pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    with served(tmp_path_factory.mktemp("served"), "vega") as started:
        yield started


def status(server, path="/1", **headers):
    """The status of an answer, and what it lets a client keep."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=20)
    headers.setdefault("Host", f"127.0.0.1:{server.port}")
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    with contextlib.closing(connection):
        return answer.status, answer.getheader("set-cookie")


def cookie(server):
    return f"drakesep-{server.port}={server.token}"


def test_others_are_refused(server):
    told = cookie(server)
    assert status(server, f"/?token={server.token}")[0] == 200
    assert status(server, "/", Cookie=told)[0] == 303
    for path in ("/", "/1", "/favicon.ico", "/_nicegui_ws/socket.io/?EIO=4"):
        assert status(server, path) == (403, None), path
        assert status(server, path, Cookie=told, Host="example.org") == (403, None)
        origin = {"Origin": "http://example.org"}
        assert status(server, path, Cookie=told, **origin) == (403, None)
    assert status(server, "/?token=wrong") == (403, None)


@pytest.mark.parametrize("why", ["no cookie", "foreign origin", "foreign host", ""])
def test_websockets_of_others_are_refused(server, why):
    host = "example.org" if why == "foreign host" else f"127.0.0.1:{server.port}"
    origin = "example.org" if why == "foreign origin" else host
    lines = [
        "GET /_nicegui_ws/socket.io/?EIO=4&transport=websocket HTTP/1.1",
        f"Host: {host}",
        f"Origin: http://{origin}",
        *(() if why == "no cookie" else (f"Cookie: {cookie(server)}",)),
        *("Connection: Upgrade", "Upgrade: websocket", "Sec-WebSocket-Version: 13"),
        *("Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==", "", ""),
    ]
    with socket.create_connection(("127.0.0.1", server.port), timeout=20) as asking:
        asking.sendall("\r\n".join(lines).encode())
        answer = asking.recv(4096).split(b"\r\n")[0]
    assert (b" 101 " if not why else b" 403 ") in answer + b" "


def test_it_listens_on_this_machine_alone(server):
    listening = [
        line.split()[1]
        for line in Path("/proc/net/tcp").read_text().splitlines()[1:]
        if line.split()[3] == "0A" and line.split()[1].endswith(f":{server.port:04X}")
    ]
    assert listening == [f"0100007F:{server.port:04X}"]


def cell(*path):
    """The field of a value, as CSS."""
    keys = ",".join(f'"{k}"' if isinstance(k, str) else str(k) for k in path)
    return f"[data-cell='[{keys}]']"


def text_of(selector):
    return f"(document.querySelector({selector!r})?.innerText ?? '')"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    home = tmp_path_factory.mktemp("page")
    write_case(home, small_case(), "small.yaml")
    return home


@pytest.fixture(scope="module")
def page(folder):
    with opened(folder, "small.yaml") as page:
        yield page


def as_before(page):
    """Wait until tables, problems and header are all those of the file."""
    field = f"document.querySelector(`{cell('bodies', 'upper', 'mass_kg')}`)"
    page.wait(f"{field}.value === '1200.0' && !{field}.className")
    page.wait("document.querySelector('.problems').classList.contains('hidden')")


STATE = text_of(".case-state")


def test_a_cell_is_changed_its_error_stands_there_and_undo_brings_it_back(page):
    mass = cell("bodies", "upper", "mass_kg")
    page.wait(f"document.querySelector(`{mass}`)")
    page.fill(mass, "1210")
    page.wait(f"{STATE} === 'not saved'")
    page.fill(mass, "-4")
    page.wait(f"{STATE} === '1 wrong'")
    told = page.wait(text_of(".problems"))
    assert told == "bodies.upper.mass_kg: must be > 0, got -4"
    wrong = "[...document.querySelectorAll('.tables input.wrong')].map(e => e.title)"
    assert page.value(wrong) == [told]
    for left in ("not saved", "small.yaml"):
        page.click("[aria-label^='Undo']")
        page.wait(f"{STATE} === '{left}'")
    as_before(page)


def test_what_is_no_yaml_stays_in_its_cell_with_the_error(page):
    field = f"document.querySelector(`{cell('bodies', 'upper', 'mass_kg')}`)"
    page.fill(cell("bodies", "upper", "mass_kg"), "{")
    page.wait(f"{field}.className === 'wrong' && {field}.value === '{{'")
    page.wait(f"{field}.title.includes('must be YAML')")
    assert page.value(STATE) == "small.yaml"  # the case is as it was
    page.fill(cell("bodies", "upper", "mass_kg"), "1200.0")
    as_before(page)


def test_another_page_on_the_file_is_not_overwritten(page, folder):
    page.fill(cell("bodies", "upper", "mass_kg"), "1215")
    page.wait(f"{STATE} === 'not saved'")
    file = folder / "small.yaml"
    before = file.read_text()
    file.write_text(before + "# somebody else\n")
    page.click("[aria-label^='Save']")
    page.wait("document.body.innerText.includes('changed by somebody else')")
    page.click_text("Save as another", ".q-dialog")
    page.wait("document.body.innerText.includes('Save the case as a file')")
    page.wait("document.querySelectorAll('.q-dialog').length === 1")
    page.press("Escape")
    assert file.read_text() == before + "# somebody else\n"
    file.write_text(before)
    page.wait("!document.querySelector('.q-dialog')")
    page.click("[aria-label^='Save']")
    page.wait(f"{STATE} === 'small.yaml'")
    changed = [
        (old, new)
        for old, new in zip(
            before.splitlines(), file.read_text().splitlines(), strict=True
        )
        if old != new
    ]
    assert len(changed) == 1 and changed[0][1].strip() == "mass_kg: 1215"


def rate(page):
    """The last value of the second curve of the first chart: this run's."""
    return page.value(
        """(() => { const id = document.querySelector('.play-chart').id.slice(1);
        const chart = getElement(Number(id)).chart;
        return chart.getOption().series[1].data.at(-1)[1]; })()"""
    )


def test_a_slider_moves_the_motion_and_a_killed_process_is_told(page):
    page.click_text("Play", "header")
    page.wait("document.querySelector('.play-fares td')")
    before = rate(page)
    page.fill(".slider-value", "1190")
    page.wait("document.querySelector('.play-command').innerText.includes('1190')")
    moved = rate(page)
    assert moved != before
    for process in _flying():
        os.kill(process, signal.SIGKILL)
    page.fill(".slider-value", "1195")
    page.wait("document.body.innerText.includes('it is started again')")
    page.wait("document.querySelector('.play-command').innerText.includes('1195')")
    page.click_text("Reset", ".play-tools")
    page.wait("!document.querySelector('.slider.moved')")
    page.wait("!document.querySelector('.play-command').innerText.includes('--set')")
    assert rate(page) == before


def _flying():
    """Processes of loky below this one: those that fly."""
    found, parents = [], {os.getpid()}
    for _ in range(4):
        for stat in Path("/proc").glob("[0-9]*/stat"):
            with contextlib.suppress(OSError):
                number, rest = stat.read_text().split(" (", 1)
                if int(rest.rpartition(") ")[2].split()[1]) in parents:
                    parents.add(int(number))
    for one in parents:
        with contextlib.suppress(OSError):
            words = Path(f"/proc/{one}/cmdline").read_bytes()
            if b"popen_loky" in words:
                found.append(one)
    return found


def test_no_request_leaves_the_machine_and_nothing_complains(page):
    # `requests` are of all that has happened since the page was opened.
    assert {url.split("/")[2].split(":")[0] for url in page.requests} == {"127.0.0.1"}
    ours = [c for c in page.complaints if "GL" not in str(c)]  # WebGL without a GPU
    assert not ours


def test_every_tab_is_reached_by_the_keyboard_and_a_page_is_there_again(page):
    page.value("document.querySelector('.q-tab').focus()")
    page.press("ArrowRight")
    page.press("Enter")
    active = "document.querySelector('.q-tab--active')?.innerText"
    page.wait(f"{active} === 'Play'")
    page.value("window.before = true; location.reload()")
    page.wait(f"!window.before && {READY}")
    page.wait(f"{active} === 'Play'")


def test_the_address_holds_no_token_once_the_page_is_open(server):
    with browser() as page:
        page.open(server.address, 1280, 800)
        page.wait(READY)
        assert "token" not in page.value("location.href + document.cookie")
