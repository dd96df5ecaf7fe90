"""The printed link works from the moment it is printed."""

import socket
from threading import Timer

import pytest

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
