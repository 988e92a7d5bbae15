"""The page stays small: in a lecture it is sent to sixty students at once over one network."""

import urllib.request

from tests.app.conftest import OpenHouse

MOST = 722_000
"""Largest compressed page [bytes]; nine tenths of it are viser's client."""


def test_the_page_with_all_features_is_not_larger_than_allowed(house: OpenHouse) -> None:
    request = urllib.request.Request(house().url, headers={"Accept-Encoding": "gzip"})
    with urllib.request.urlopen(request, timeout=30.0) as answer:
        assert answer.headers["Content-Encoding"] == "gzip"
        assert len(answer.read()) <= MOST
