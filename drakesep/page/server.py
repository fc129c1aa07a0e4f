"""The server of the page: on this machine alone, in this process.

Nothing that flies is imported here: Drake and JAX live in processes of their own, so
that the page is there soon after the command, and stays where one of them ends.
"""

import logging
import secrets
import socket
import threading
import time
import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import Any

from drakesep.case_file.reader import read_text
from drakesep.page.access import Guard
from drakesep.systems.checks import InputError


_LONGEST_MESSAGE = 16_000_000
"""Bytes of what a browser sends at once: a case file is at most 10 MB."""


def serve(
    case: str | None,
    *,
    port: int | None = None,
    opens_browser: bool = True,
    results: Path = Path("results"),
    say: Callable[[str], None] = print,
) -> None:
    """Serve the page until the process is interrupted.

    Args:
        case: a case file or the name of a built-in case that is opened at first; a new
            case if None.
        port: of 127.0.0.1; a free one if None.
        opens_browser: whether to open the page in the user's browser.
        results: folder with results of studies.
        say: told the address.

    Raises:
        ValueError: the file cannot be read, NiceGUI is missing, or the port is taken.
    """
    if case is not None:
        read_text(case)  # what cannot be read is said here, what is wrong on the page
    check_installed()
    listening = _listen(port)
    port = listening.getsockname()[1]
    token = secrets.token_urlsafe(32)
    address = f"http://127.0.0.1:{port}/?token={token}"
    # Other users of this machine see what a browser is started with: that works once.
    once = secrets.token_urlsafe(32)
    guard = Guard(_application(case, results), token, f"drakesep-{port}", once)
    server = _server(guard)
    say(address)
    if opens_browser:
        opening = server, f"http://127.0.0.1:{port}/?token={once}"
        threading.Thread(target=_open_when_ready, args=opening, daemon=True).start()
    server.run(sockets=[listening])


def check_installed() -> None:
    """Raise ValueError unless what the page is made with is installed."""
    from importlib.util import find_spec

    if find_spec("nicegui") is None:
        raise InputError("the page needs NiceGUI: pip install 'drakesep[ui]'")


def _listen(port: int | None) -> socket.socket:
    """Return a socket that listens on this machine alone."""
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind(("127.0.0.1", port or 0))
        listening.listen()  # who comes before the server is ready waits
    except OSError as error:
        listening.close()
        raise InputError(
            f"--port: must be free, got {port}: {error.strerror}"
        ) from error
    return listening


def _application(case: str | None, results: Path) -> Any:
    """Return the page as an ASGI application."""
    from fastapi import FastAPI
    from nicegui import ui

    from drakesep.page import shell

    application = FastAPI(openapi_url=None)
    shell.add_pages(case, results)
    ui.run_with(
        application,
        title="drakesep",
        favicon=Path(__file__).with_name("favicon.svg"),
        dark=None,
        tailwind=False,
        show_welcome_message=False,
        reconnect_timeout=30.0,
    )
    return application


def _server(guard: Guard) -> Any:
    import uvicorn

    logging.getLogger("nicegui").setLevel(logging.WARNING)
    return uvicorn.Server(
        uvicorn.Config(
            guard,
            ws="wsproto",
            ws_max_size=_LONGEST_MESSAGE,
            log_level="warning",
            lifespan="on",
            timeout_graceful_shutdown=1,
            server_header=False,
        )
    )


def _open_when_ready(server: Any, address: str) -> None:
    while not server.started:
        time.sleep(0.02)
    webbrowser.open(address)
