"""Only this machine's browser, with the printed token, is answered."""

import pytest

starlette = pytest.importorskip("starlette.testclient", reason="the workbench's extra is not installed")

from starlette.responses import PlainTextResponse  # noqa: E402
from starlette.testclient import TestClient  # noqa: E402
from starlette.websockets import WebSocketDisconnect  # noqa: E402

from pyident.workbench.guard import Guard  # noqa: E402

HOST = "127.0.0.1:8000"


async def inner(scope, receive, send):
    if scope["type"] == "websocket":
        await send({"type": "websocket.accept"})
        await send({"type": "websocket.close"})
        return
    await PlainTextResponse("inside")(scope, receive, send)


@pytest.fixture
def client():
    guard = Guard(inner, "secret-token", frozenset({HOST}), "flexident8000")
    return TestClient(guard, base_url=f"http://{HOST}")


def test_the_printed_link_opens_and_leaves_a_cookie(client):
    assert client.get("/?token=secret-token").text == "inside"
    assert client.get("/anything").text == "inside"  # the cookie alone


@pytest.mark.parametrize("url", ["/", "/?token=", "/?token=other", "/_nicegui/x.js"])
def test_without_the_token_nothing_is_answered(client, url):
    assert client.get(url).status_code == 403


@pytest.mark.parametrize("host", ["evil.example:8000", "127.0.0.1:9", "localhost", ""])
def test_another_host_name_is_refused(client, host):
    assert client.get("/?token=secret-token", headers={"host": host}).status_code == 403


def test_another_origin_is_refused(client):
    answer = client.get("/?token=secret-token", headers={"origin": "http://evil.example"})
    assert answer.status_code == 403


def test_a_web_socket_needs_the_token_too(client):
    with pytest.raises(WebSocketDisconnect), client.websocket_connect(f"ws://{HOST}/ws"):
        pass
    with client.websocket_connect(f"ws://{HOST}/ws?token=secret-token"):
        pass
