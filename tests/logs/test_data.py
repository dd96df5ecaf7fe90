"""Data sets are fetched from a server, once, and only if they are what they should be."""

import hashlib
import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import pytest
from click.testing import CliRunner

from pyident.cli.main import main
from pyident.logs import datasets as data
from pyident.logs.datasets import DataSet, Recording
from pyident.logs.log import LogError

CONTENT = b"time,joint1.e\n0,0\n"


class _Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


@pytest.fixture
def server(tmp_path, monkeypatch):
    """A server with the file of a data set `small`, which is not on this machine; files' place on it."""
    there = tmp_path / "server" / "owner" / "name" / "abc" / "raw data"
    there.mkdir(parents=True)
    (there / "log.csv").write_bytes(CONTENT)
    recording = Recording("A/log.csv", "raw data/log.csv", hashlib.sha256(CONTENT).hexdigest())
    small = DataSet("a small one", "none", "owner/name", "abc", (recording,))
    monkeypatch.setitem(data.DATA_SETS, "small", small)
    monkeypatch.delenv("PYIDENT_DATA", raising=False)
    monkeypatch.setattr("pooch.os_cache", lambda _: tmp_path / "cache")
    http = ThreadingHTTPServer(("127.0.0.1", 0), partial(_Quiet, directory=str(tmp_path / "server")))
    thread = threading.Thread(target=http.serve_forever, daemon=True)
    thread.start()
    monkeypatch.setattr(data, "_RAW", f"http://127.0.0.1:{http.server_port}")
    yield there
    http.shutdown()
    http.server_close()
    thread.join()


def test_a_file_is_fetched_once(server):
    (file,) = data.fetch("small")
    assert file.read_bytes() == CONTENT
    assert file.parts[-3:] == ("small", "A", "log.csv")
    (server / "log.csv").unlink()
    assert data.fetch("small") == [file]
    assert data.fetch("small", download=False) == [file]


def test_a_wrong_file_is_refused_and_not_kept(server):
    (server / "log.csv").write_bytes(b"something else")
    with pytest.raises(LogError, match=r"raw%20data/log\.csv cannot be fetched \(.*hash") as refused:
        data.fetch("small")
    assert "PYIDENT_DATA" in str(refused.value)
    with pytest.raises(LogError, match="run: pyident data fetch small"):
        data.fetch("small", download=False)


def test_a_missing_file_is_one_sentence(server):
    (server / "log.csv").unlink()
    with pytest.raises(LogError, match=r"cannot be fetched .*404"):
        data.fetch("small")


def test_offline_the_command_says_what_to_do(server, monkeypatch):
    monkeypatch.setattr(data, "_RAW", "http://127.0.0.1:9")
    done = CliRunner().invoke(main, ["data", "fetch", "small"])
    assert done.exit_code == 2
    assert done.output.startswith(
        "error: http://127.0.0.1:9/owner/name/abc/raw%20data/log.csv cannot be fetched"
    )
    assert "set PYIDENT_DATA to a folder with small" in done.output
    assert "Traceback" not in done.output


def test_the_commands(server):
    listed = CliRunner().invoke(main, ["data", "list"])
    assert listed.exit_code == 0
    assert "a small one" in listed.output
    fetched = CliRunner().invoke(main, ["data", "fetch", "small"])
    assert fetched.exit_code == 0
    assert fetched.output.strip().endswith("log.csv")
