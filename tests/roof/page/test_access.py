"""Who may speak to the page: every way in that is not the user's own is refused."""

import asyncio

import pytest

from drakesep.page.access import Guard


TOKEN, COOKIE, ONCE = "told", "drakesep-8123", "good for one time"
HERE = "127.0.0.1:8123"
KNOWN = {"host": HERE, "cookie": f"other=1; {COOKIE}={TOKEN}"}


async def application(scope, receive, send):
    await send({"type": "http.response.start", "status": 204, "headers": []})
    await send({"type": "http.response.body", "body": b""})


def asked(headers, query="", kind="http", guard=None):
    """What is answered: messages of ASGI."""
    guard = guard or Guard(application, TOKEN, COOKIE)
    told = []

    async def send(message):
        told.append(message)

    scope = {
        "type": kind,
        "query_string": query.encode(),
        "headers": [(k.encode(), v.encode()) for k, v in headers.items()],
    }
    asyncio.run(guard(scope, None, send))
    return told


def headers_of(message):
    return {name.decode(): value.decode() for name, value in message["headers"]}


@pytest.mark.parametrize("kind", ["http", "websocket"])
@pytest.mark.parametrize("host", [HERE, "localhost:8123", "localhost:9000"])
@pytest.mark.parametrize("origin", [False, True])
def test_who_has_the_cookie_is_let_through(kind, host, origin):
    more = {"origin": f"http://{host}"} if origin else {}
    assert asked({**KNOWN, "host": host, **more}, kind=kind)[0]["status"] == 204


@pytest.mark.parametrize(
    "others", ['a={"b": 1, "c"}', "a b=\x01", "=;;", f"{COOKIE}=old", 'q="un', "é=1"]
)
def test_cookies_of_other_programs_do_not_hide_ours(others):
    cookies = f"{others}; {COOKIE}={TOKEN}"
    assert asked({"host": HERE, "cookie": cookies})[0]["status"] == 204


REFUSED = {
    "no token": ({"host": HERE}, ""),
    "another token": ({"host": HERE}, "token=tole"),
    "another cookie": ({"host": HERE, "cookie": f"{COOKIE}=tole"}, ""),
    "a cookie of another server": ({"host": HERE, "cookie": f"drakesep={TOKEN}"}, ""),
    "broken cookies": ({"host": HERE, "cookie": f"{COOKIE}={TOKEN}\x01;;="}, ""),
    "a cookie that ends like ours": (
        {"host": HERE, "cookie": f"x{COOKIE}={TOKEN}"},
        "",
    ),
    "another host that leads here": ({**KNOWN, "host": "example.org:8123"}, ""),
    "a host that begins like ours": ({**KNOWN, "host": "127.0.0.1.example.org"}, ""),
    "no host": ({"cookie": KNOWN["cookie"]}, ""),
    "a foreign origin": ({**KNOWN, "origin": "http://example.org"}, ""),
    "another port's origin": ({**KNOWN, "origin": "http://127.0.0.1:8124"}, ""),
    "a secure origin": ({**KNOWN, "origin": f"https://{HERE}"}, ""),
    "the origin of a file": ({**KNOWN, "origin": "null"}, ""),
    "a foreign origin with the token": (
        {"host": HERE, "origin": "http://example.org"},
        f"token={TOKEN}",
    ),
    "another host with the token": ({"host": "example.org"}, f"token={TOKEN}"),
}


@pytest.mark.parametrize(("headers", "query"), REFUSED.values(), ids=REFUSED)
def test_all_others_are_refused(headers, query):
    [start, _] = asked(headers, query)
    assert start["status"] == 403
    assert "set-cookie" not in headers_of(start)


@pytest.mark.parametrize(("headers", "query"), REFUSED.values(), ids=REFUSED)
def test_websockets_are_refused_before_they_are_accepted(headers, query):
    [told] = asked(headers, query, kind="websocket")
    assert told["type"] == "websocket.close"


def test_no_websocket_is_opened_by_the_token_in_its_address():
    told = asked({"host": HERE}, f"token={TOKEN}", kind="websocket")
    assert told[0]["type"] == "websocket.close"


def test_the_token_is_exchanged_for_a_cookie_that_no_script_and_no_other_site_has():
    [start, body] = asked({"host": HERE}, f"token={TOKEN}")
    cookie = headers_of(start)["set-cookie"]
    assert cookie == f"{COOKIE}={TOKEN}; Path=/; HttpOnly; SameSite=Strict"
    assert TOKEN not in body["body"].decode()


def test_what_a_browser_is_started_with_is_good_for_one_time():
    guard = Guard(application, TOKEN, COOKIE, ONCE)
    query = "token=good%20for%20one%20time"
    assert asked({"host": HERE}, query, guard=guard)[0]["status"] == 200
    assert asked({"host": HERE}, query, guard=guard)[0]["status"] == 403
    assert asked({"host": HERE}, f"token={TOKEN}", guard=guard)[0]["status"] == 200


def test_the_browser_is_told_to_load_nothing_from_elsewhere():
    for told in (asked(KNOWN), asked({"host": HERE})):
        headers = headers_of(told[0])
        policy = headers["content-security-policy"]
        sources = policy.replace(";", " ").split()
        assert not [s for s in sources if "http" in s or s == "*"]
        assert policy.startswith("default-src 'self'")
        assert headers["referrer-policy"] == "no-referrer"
