"""Serves the workbench of one folder on the loopback."""

import secrets
import socket
from pathlib import Path
from threading import Thread
from time import monotonic, sleep

from pyident.workbench.project import ProjectError, open_project

_PATIENCE = 120.0  # s that a page on a busy machine may be silent before it is taken for closed


def free_port(port: int) -> int:
    """`port` if it is free, one that the system chooses for 0. Raises ProjectError."""
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", port))
        except OSError:
            raise ProjectError(f"port {port} is taken; choose another with --port") from None
        return int(probe.getsockname()[1])


def answers(port: int, seconds: float = 60.0) -> bool:
    """Wait until something listens on the port; False where nothing does after so many seconds."""
    end = monotonic() + seconds
    while monotonic() < end:
        try:
            socket.create_connection(("127.0.0.1", port), timeout=1.0).close()
            return True
        except OSError:
            sleep(0.02)
    return False


def serve(folder: str | Path, port: int = 0, browser: bool = True) -> None:
    """Serve until it is stopped; prints the URL. Raises ProjectError."""
    project = open_project(folder)
    port = free_port(port)
    token = secrets.token_urlsafe(24)
    try:
        from nicegui import app, ui
    except ImportError:
        raise ProjectError("the workbench needs NiceGUI; pip install 'flexident[workbench]'") from None
    from fastapi import Request

    from pyident.workbench.bench import Bench
    from pyident.workbench.guard import Guard
    from pyident.workbench.page import Page
    from pyident.workbench.view import view_of

    bench = Bench(project)
    hosts = frozenset({f"127.0.0.1:{port}", f"localhost:{port}"})

    ui.tooltip.default_classes("bg-grey-10")  # the framework's own grey is too pale to read

    @ui.page("/", title="flexident", language="en-US")
    def index(request: Request) -> None:
        Page(bench, view_of(request.query_params)).build()

    url = f"http://127.0.0.1:{port}/?token={token}"

    def announced() -> None:
        if not answers(port):
            return
        print(url, flush=True)
        if browser:
            import webbrowser

            webbrowser.open(url)

    # the server calls back before it listens, and whoever follows the link then is refused
    app.on_startup(Thread(target=announced, daemon=True).start)
    app.on_shutdown(bench.close)
    app.add_middleware(Guard, token=token, hosts=hosts, cookie=f"flexident{port}")
    ui.run(
        host="127.0.0.1",
        port=port,
        show=False,
        reload=False,
        show_welcome_message=False,
        title="flexident",
        reconnect_timeout=_PATIENCE,
    )
