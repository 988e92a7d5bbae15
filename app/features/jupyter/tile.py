"""The tile in Jupyter's launcher, an entry point for jupyter-server-proxy. Imports nothing of Jupyter."""

import secrets
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from app.features.store import IN_MEMORY
from app.features.workers import ONE_PROCESS

ICON: Final = Path(__file__).parents[2] / "web" / "static" / "mark.svg"


def tile() -> dict[str, Any]:
    made = proxied((*IN_MEMORY, *ONE_PROCESS, "--edit-law"))
    # Only requests through this notebook server and its login have the secret; their senders can run programs
    # here anyway.
    secret = secrets.token_urlsafe(32)
    made["environment"] = {"DUET_PROOF": secret}
    made["request_headers_override"]["X-Duet-Proof"] = secret
    return {**made, "launcher_entry": {"title": "Duet", "icon_path": str(ICON)}}


def proxied(options: Sequence[str]) -> dict[str, Any]:
    """Start command for jupyter-server-proxy. `options`: of `lwr-duet serve`."""
    return {
        # Without -P, a folder named `app` in the notebook's folder would be started.
        "command": [sys.executable, "-P", "-m", "app", "serve", "--no-open", "--port", "{port}", *options],
        "timeout": 120.0,
        # Also for websockets, see `app.web.origin_policy.VOUCHED`: under a hub, Origin and Host are the
        # hub's.
        "request_headers_override": {"X-Forwarded-Context": "{base_url}"},
    }
