"""A real JupyterHub with three users: each has a private Duet in a tile, and all share one as a service.

Skipped without jupyterhub (`pip install jupyterhub`) or its proxy (`npm install -g configurable-http-proxy`).
"""

import json
import re
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

import pytest
import requests
import websockets
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin, Subprotocol

from app.web.viser_internals import VISER_VERSION
from tests.app.features.jupyter.conftest import environment, goes_on
from tests.app.page.helpers import click, shown
from tests.blocking_client import BlockingClient
from tests.browser import free_port

pytest.importorskip("jupyterhub", reason="jupyterhub is not installed")
if shutil.which("configurable-http-proxy") is None:
    pytest.skip("configurable-http-proxy is not installed", allow_module_level=True)


pytestmark = pytest.mark.thorough

USERS = ("ann", "bob", "eve")
PASSWORD = "a password for the tests"
NAME = "hub.example.org"

CONFIG = """
c = get_config()
c.JupyterHub.bind_url = "http://127.0.0.1:{ports[0]}"
c.JupyterHub.hub_bind_url = "http://127.0.0.1:{ports[1]}"
c.ConfigurableHTTPProxy.api_url = "http://127.0.0.1:{ports[2]}"
c.JupyterHub.authenticator_class = "shared-password"
c.SharedPasswordAuthenticator.user_password = {password!r}
c.Authenticator.allowed_users = set({users!r})
c.JupyterHub.spawner_class = "simple"
c.SimpleLocalProcessSpawner.home_dir_template = {home!r} + "/{{username}}"
c.Spawner.args = ["--allow-root"]
c.Spawner.http_timeout = 120
c.JupyterHub.services = [{{
    "name": "duet",
    "url": "http://127.0.0.1:{ports[3]}",
    "command": [{python!r}, "-P", "-m", "app.features.jupyter.hub_service", "--store", "memory"],
    "oauth_no_confirm": True,
}}]
c.JupyterHub.load_roles = [{{"name": "user", "scopes": ["self", "access:services!service=duet"]}}]
"""


@dataclass(frozen=True)
class Hub:
    port: int
    process: subprocess.Popen[bytes]

    def get(self, visitor: requests.Session, path: str) -> requests.Response:
        """Request a path under the hub's public name, which this computer cannot resolve."""
        for _ in range(20):
            answer = visitor.get(
                f"http://127.0.0.1:{self.port}{path}",
                headers={"Host": NAME},
                allow_redirects=False,
                timeout=60,
            )
            if not answer.is_redirect:
                return answer
            target = urlsplit(answer.headers["Location"])
            path = f"{target.path}?{target.query}" if target.query else target.path
        raise AssertionError(f"no end of redirections, the last one to {path}")

    def login(self, user: str) -> requests.Session:
        visitor = requests.Session()
        (token,) = re.findall(r'name="_xsrf" value="([^"]+)"', self.get(visitor, "/hub/login").text)
        form = {"username": user, "password": PASSWORD, "_xsrf": token}
        visitor.post(
            f"http://127.0.0.1:{self.port}/hub/login",
            form,
            headers={"Host": NAME},
            allow_redirects=False,
            timeout=60,
        )
        return visitor

    def ask(self, visitor: requests.Session, method: str, path: str) -> requests.Response:
        """Send a request to an API of the hub or of a user's server, as its pages do."""
        (token,) = {
            one.value
            for one in visitor.cookies
            if one.name == "_xsrf" and path.startswith(one.path) and one.path != "/"
        }
        headers = {"Host": NAME, "X-XSRFToken": str(token), "Referer": f"http://{NAME}/hub/home"}
        return visitor.request(method, f"http://127.0.0.1:{self.port}{path}", headers=headers, timeout=60)

    def websocket(
        self,
        visitor: requests.Session,
        path: str,
        origin: str = f"http://{NAME}",
        protocol: str = f"viser-v{VISER_VERSION}",
    ) -> ClientConnection:
        """A websocket under the hub's public name."""
        cookies = "; ".join(
            f"{one.name}={one.value}" for one in visitor.cookies if path.startswith(one.path.rstrip("/"))
        )
        return connect(
            f"ws://{NAME}{path}",
            sock=socket.create_connection(("127.0.0.1", self.port)),
            origin=Origin(origin),
            subprotocols=[Subprotocol(protocol)] if protocol else None,
            additional_headers={"Cookie": cookies} if cookies else {},
            open_timeout=60.0,
            proxy=None,
        )

    def first_message(
        self, visitor: requests.Session, path: str, origin: str = f"http://{NAME}"
    ) -> bytes | str:
        """First message that a page gets on its websocket."""
        with self.websocket(visitor, path, origin) as connection:
            return connection.recv(60.0)

    def wait_for_tile(self, visitor: requests.Session, user: str) -> None:
        """Wait while the hub answers with its waiting page."""
        deadline = time.monotonic() + 120.0
        while "duet-loading" not in self.get(visitor, f"/user/{user}/duet/").text:
            assert time.monotonic() < deadline and goes_on(self.process)


@pytest.fixture(scope="module")
def hub(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Hub]:
    home = tmp_path_factory.mktemp("hub")
    ports = [free_port() for _ in range(4)]
    config = CONFIG.format(ports=ports, password=PASSWORD, users=USERS, home=str(home), python=sys.executable)
    (home / "jupyterhub_config.py").write_text(config, encoding="utf-8")
    around: Mapping[str, str] = environment(home)
    path = f"{Path(sys.executable).parent}:{around['PATH']}"
    with (home / "log").open("wb") as log:
        process = subprocess.Popen(
            [sys.executable, "-m", "jupyterhub"],
            cwd=home,
            env={**around, "PATH": path},
            stdout=log,
            stderr=subprocess.STDOUT,
        )
        try:
            deadline = time.monotonic() + 90.0
            while not _answers(ports[0]):
                assert goes_on(process) and time.monotonic() < deadline, (home / "log").read_text(
                    encoding="utf-8"
                )
            yield Hub(ports[0], process)
        finally:
            process.terminate()
            process.wait(60)


def _answers(port: int) -> bool:
    try:
        return requests.get(f"http://127.0.0.1:{port}/hub/health", timeout=5).status_code == 200
    except requests.RequestException:
        return False


@pytest.fixture(scope="module")
def visitors(hub: Hub) -> dict[str, requests.Session]:
    """The three users, each with a started server."""
    found = {user: hub.login(user) for user in USERS}
    for visitor in found.values():
        hub.get(visitor, "/hub/spawn")
    for user, visitor in found.items():
        hub.wait_for_tile(visitor, user)
    return found


def test_every_user_has_a_private_duet(hub: Hub, visitors: dict[str, requests.Session]) -> None:
    for user, visitor in visitors.items():
        assert hub.first_message(visitor, f"/user/{user}/duet/")
    assert hub.get(visitors["bob"], "/user/ann/duet/").status_code == 403
    with ExitStack() as opened:
        # Two tiles of one user and one of another.
        for user in ("ann", "ann", "bob"):
            assert opened.enter_context(hub.websocket(visitors[user], f"/user/{user}/duet/")).recv(30.0)


def test_a_culled_server_restarts_with_its_tile(hub: Hub, visitors: dict[str, requests.Session]) -> None:
    eve = visitors["eve"]
    # The same request as from jupyterhub-idle-culler.
    assert hub.ask(eve, "DELETE", "/hub/api/users/eve/server").status_code in (202, 204)
    deadline = time.monotonic() + 60.0
    while "duet-loading" in hub.get(eve, "/user/eve/duet/").text:
        assert time.monotonic() < deadline
    hub.get(eve, "/hub/spawn")
    hub.wait_for_tile(eve, "eve")
    assert hub.first_message(eve, "/user/eve/duet/")


def test_a_notebook_shows_a_lesson_in_a_cell(hub: Hub, visitors: dict[str, requests.Session]) -> None:
    ann = visitors["ann"]
    hub.get(ann, "/user/ann/api/status")
    kernel = hub.ask(ann, "POST", "/user/ann/api/kernels").json()["id"]
    header = {
        "msg_id": "1",
        "session": "2",
        "username": "ann",
        "msg_type": "execute_request",
        "version": "5.3",
    }
    content = {
        "code": "from app.features.jupyter import duet\nduet.show(lesson=4)",
        "silent": False,
        "user_expressions": {},
    }
    request = {"header": header, "parent_header": {}, "metadata": {}, "content": content, "channel": "shell"}
    with hub.websocket(ann, f"/user/ann/api/kernels/{kernel}/channels", protocol="") as channels:
        channels.send(json.dumps(request))
        page = ""
        while not page:
            message = json.loads(channels.recv(60.0))
            assert message["msg_type"] != "error", message["content"]
            page = message["content"].get("data", {}).get("text/html", "")
    (port,), (query,) = re.findall(r'"port": (\d+)', page), re.findall(r'"query": "([^"]*)"', page)
    path = f"/user/ann/proxy/{port}/?{query}"
    assert "duet-loading" in hub.get(ann, path).text and hub.first_message(ann, path)
    assert hub.get(visitors["bob"], path).status_code == 403


def test_all_users_share_the_service(hub: Hub, visitors: dict[str, requests.Session]) -> None:
    for visitor in visitors.values():
        assert "duet-loading" in hub.get(visitor, "/services/duet/").text
        assert hub.first_message(visitor, "/services/duet/")


def test_two_users_hold_an_arm_each(hub: Hub, visitors: dict[str, requests.Session]) -> None:
    def come(opened: ExitStack, user: str, path: str, query: str) -> BlockingClient:
        # This request fetches the cookies.
        hub.get(visitors[user], f"{path}/")
        cookies = "; ".join(
            f"{one.name}={one.value}"
            for one in visitors[user].cookies
            if path.startswith(one.path.rstrip("/"))
        )
        address = f"http://127.0.0.1:{hub.port}"
        return opened.enter_context(
            BlockingClient(f"{address}{path}", address, query, headers={"Cookie": cookies})
        )

    with ExitStack() as opened:
        host = come(opened, "ann", "/services/duet", f"scene=hold&resume={1:032d}&folder=/services/duet")
        host.wait_for(lambda v: len(v.mirror.commands) >= 14)
        click(host, "Invite a second person")
        host.wait_for(lambda v: re.search(r'value="[^"]*/services/duet/\?guest=[0-9a-f]{16}"', shown(v)))
        (word,) = set(re.findall(r"guest=([0-9a-f]{16})", shown(host)))
        guest = come(opened, "bob", "/services/duet", f"guest={word}&resume={2:032d}&lang=de")
        guest.wait_for(lambda v: "Sie halten den silbernen Arm" in shown(v))
        host.wait_for(lambda v: "The second person is here" in shown(v))
        # Bob has no access to Ann's own server.
        with pytest.raises(websockets.InvalidStatus, match="403"):
            come(opened, "bob", "/user/ann/duet", f"guest={word}")


@pytest.mark.parametrize("path", ["/user/ann/duet/", "/services/duet/"])
def test_no_path_bypasses_the_login(hub: Hub, visitors: dict[str, requests.Session], path: str) -> None:
    assert "duet-loading" in hub.get(visitors["ann"], path).text
    stranger = requests.Session()
    assert "duet-loading" not in hub.get(stranger, path).text
    for visitor, origin in ((stranger, f"http://{NAME}"), (visitors["ann"], "http://evil.example")):
        with pytest.raises(websockets.InvalidStatus, match="403"):
            hub.first_message(visitor, path, origin)
