"""A service of a JupyterHub: `python -m app.features.jupyter.hub_service` with options of `lwr-duet serve`.

Needs jupyterhub, jupyter-server-proxy, and the hub's environment for services.
"""

import sys
from typing import Any

from jupyter_server_proxy.standalone.app import StandaloneProxyServer
from tornado.web import HTTPError

from app.features.jupyter.tile import proxied


class HubService(StandaloneProxyServer):
    """Authenticates websockets too, which jupyter-server-proxy's server does not."""

    def make_proxy_handler(self) -> tuple[type | None, dict[str, Any]]:
        handler, arguments = super().make_proxy_handler()
        assert handler is not None

        class Authenticated(handler):
            def prepare(self) -> None:
                # The handler itself sends a page to the hub's login; a websocket cannot be sent there.
                if self.request.headers.get("Upgrade", "").lower() == "websocket" and not self.current_user:
                    raise HTTPError(403)

        return Authenticated, arguments


if __name__ == "__main__":
    # Serves until the hub ends the process.
    service = HubService(name="duet", **proxied(sys.argv[1:]))
    service.initialize([])
    service.start()
