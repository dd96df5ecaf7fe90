"""The printed link works from the moment it is printed."""

import os
import signal
import socket
import subprocess
import sys
from threading import Timer
from urllib.error import HTTPError
from urllib.request import HTTPCookieProcessor, build_opener

import pytest
from click.testing import CliRunner

from pyident.cli.main import main
from pyident.workbench.project import ProjectError
from pyident.workbench.server import answers, free_port


def test_it_waits_until_someone_listens():
    port = free_port(0)
    assert not answers(port, seconds=0.1)
    with socket.socket() as late:
        late.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        late.bind(("127.0.0.1", port))
        Timer(0.2, late.listen).start()
        assert answers(port, seconds=30)


def test_a_taken_port_is_one_sentence():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(ProjectError, match="is taken; choose another with --port"):
            free_port(taken.getsockname()[1])


def test_it_serves_the_page_until_it_is_asked_to_end(tmp_path):
    """The command as a person runs it: the printed link opens the page, another is refused."""
    words = [sys.executable, "-m", "pyident", "open", str(tmp_path), "--no-browser"]
    plain = {key: value for key, value in os.environ.items() if not key.startswith(("PYTEST", "NICEGUI"))}
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=plain) as process:
        assert process.stdout is not None
        url = next(line.strip() for line in process.stdout if line.startswith("http"))
        with build_opener(HTTPCookieProcessor()).open(url, timeout=120) as page:
            assert "There is no log in this folder yet." in page.read().decode()
        with pytest.raises(HTTPError, match="403"):
            build_opener().open(url.partition("?")[0], timeout=120)
        process.terminate()
        assert process.wait(120) in (0, 128 + signal.SIGTERM, -signal.SIGTERM)


def test_a_folder_that_is_not_there_is_one_sentence(tmp_path):
    run = CliRunner().invoke(main, ["open", str(tmp_path / "nowhere"), "--no-browser"])
    assert run.exit_code == 2
    assert "there is no folder" in run.output
