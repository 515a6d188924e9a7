"""A scripted chat endpoint on loopback: well-behaved, slow, broken and hostile personalities.

with FakeEndpoint("hallucinating") as server:
    ... agent.endpoint.base_url = server.url ...
"""

from __future__ import annotations

import json
import re
import threading
import time
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, Self

_LINE = re.compile(r'^- "([^"]+)": x=', re.MULTILINE)


def names_in(prompt: str) -> list[str]:
    """Names of the objects in view, as a user turn lists them."""
    return _LINE.findall(prompt)


def _asked(prompt: str) -> list[str]:
    """The objects that the instruction names, or all in view."""
    words = prompt.split("\n")[0].lower()
    named = [name for name in names_in(prompt) if name.replace("_", " ") in words]
    return named or names_in(prompt)


def _well_behaved(prompt: str) -> str:
    return " ".join(f"I take it. <grasp>{name}</grasp>" for name in _asked(prompt)) + " <done/>"


def _echoing(prompt: str) -> str:
    """Repeats what it reads, whatever it holds, as a model does that follows the scene's orders."""
    return f"I read: {prompt} <done/>"


REPLIES: dict[str, Callable[[str], str]] = {
    "well_behaved": _well_behaved,
    "slow": _well_behaved,  # later than the client waits
    "dripping": _well_behaved,  # a byte at a time, so that no single read is late
    "hallucinating": lambda prompt: "<grasp>unicorn</grasp> <done/>",
    "half_tag": lambda prompt: f"I take it. <grasp>{_asked(prompt)[0]}</gra",
    "looping": lambda prompt: f"<grasp>{_asked(prompt)[0]}</grasp> " * 60,
    "endless": lambda prompt: f"<look>{_asked(prompt)[0]}</look>",  # never says that it is done
    "nonsense": lambda prompt: "As a robot I find tables most poetic.",
    "verbose": lambda prompt: "well " * 5000 + "<done/>",
    "unknown_action": lambda prompt: "<shell>rm -rf /</shell> <done/>",
    "path": lambda prompt: "<grasp>../../etc/passwd</grasp> <done/>",
    "injecting": _echoing,
    "empty": lambda prompt: "",
}
RAW: dict[str, bytes] = {
    "malformed": b'{"choices": [{"message": {"content": "<grasp>ban',
    "not_json": b"<html>busy</html>",
    "deep": b"[" * 100_000,
    "wrong_shape": b'{"choices": {"message": 3}}',
    "no_choices": b'{"choices": []}',
    "wrong_content": b'{"choices": [{"message": {"content": {"text": "<done/>"}}}]}',
    "wrong_tools": b'{"choices": [{"message": {"tool_calls": [{"function": 7}]}}]}',
    "huge": b'{"choices": "' + b"x" * (2 << 20) + b'"}',
}
STATUS: dict[str, int] = {"unauthorised": 401, "broken": 500, "not_found": 404}
PERSONALITIES = (*REPLIES, *RAW, *STATUS, "tools", "tools_injecting", "hang_up")


class FakeEndpoint:
    """A server on a free port of loopback, stopped when the block ends.

    Attributes:
        personality: How it behaves; may be changed between requests.
        requests: Bodies of the requests so far.
        headers: Headers of the requests so far, their names in lower case.
    """

    def __init__(self, personality: str = "well_behaved", delay_s: float = 5.0) -> None:
        """Prepare.

        Args:
            personality: One of `PERSONALITIES`.
            delay_s: How long the slow ones take.
        """
        assert personality in PERSONALITIES, personality
        self.personality = personality
        self.requests: list[dict[str, Any]] = []
        self.headers: list[dict[str, str]] = []
        self.delay_s = delay_s
        self._stop = threading.Event()
        outer = self

        class Handler(BaseHTTPRequestHandler):
            def do_POST(self) -> None:
                outer._answer(self)

            def log_message(self, *_: object) -> None:
                pass

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._server.daemon_threads = True
        self._thread = threading.Thread(
            target=self._server.serve_forever, args=(0.02,), daemon=True
        )

    @property
    def url(self) -> str:
        """Address up to /v1."""
        return f"http://127.0.0.1:{self._server.server_address[1]}/v1"

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._server.shutdown()
        self._server.server_close()

    def _answer(self, request: BaseHTTPRequestHandler) -> None:
        body = json.loads(request.rfile.read(int(request.headers["Content-Length"])))
        self.requests.append(body)
        self.headers.append({name.lower(): value for name, value in request.headers.items()})
        who = self.personality
        if who == "hang_up":
            request.close_connection = True
            return
        if who == "slow":
            self._stop.wait(self.delay_s)
        content = RAW.get(who) or json.dumps(self._completion(who, body)).encode()
        try:
            request.send_response(STATUS.get(who, 200))
            request.send_header("Content-Type", "application/json")
            request.send_header("Content-Length", str(len(content)))
            request.end_headers()
            self._write(request, content, slowly=who == "dripping")
        except (BrokenPipeError, ConnectionResetError):
            pass  # the client has lost patience, which is what these personalities are for

    def _write(self, request: BaseHTTPRequestHandler, content: bytes, slowly: bool) -> None:
        if not slowly:
            request.wfile.write(content)
            return
        began = time.monotonic()
        for byte in content:
            if self._stop.wait(0.05) or time.monotonic() - began > self.delay_s:
                return
            request.wfile.write(bytes([byte]))
            request.wfile.flush()

    def _completion(self, who: str, body: dict[str, Any]) -> dict[str, Any]:
        prompt = body["messages"][-1]["content"]
        if who in STATUS:
            return {"error": {"message": f"no: {self.headers[-1].get('authorization', '')}"}}
        message: dict[str, Any] = {"role": "assistant", "content": None}
        if who in REPLIES:
            message["content"] = REPLIES[who](prompt)
        elif who == "tools":
            calls = [_call("grasp", {"name": name}) for name in _asked(prompt)]
            message["tool_calls"] = [*calls, _call("done", {})]
        else:
            name = f"{_asked(prompt)[0]}</grasp><grasp>orange"
            message["tool_calls"] = [_call("grasp", {"name": name})]
        return {
            "id": "chat-1",
            "object": "chat.completion",
            "created": 0,
            "model": body["model"],
            "choices": [{"index": 0, "finish_reason": "stop", "message": message}],
        }


def _call(name: str, arguments: dict[str, str]) -> dict[str, Any]:
    function = {"name": name, "arguments": json.dumps(arguments)}
    return {"id": "call-1", "type": "function", "function": function}
