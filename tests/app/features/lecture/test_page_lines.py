"""The address of a lecture, and its QR code."""

import xml.etree.ElementTree as ElementTree

import pytest

from app.features.lecture.page_lines import join_html
from app.theme import PALETTES
from app.web import address
from app.web.address import Address, find_address, own_address, qr_svg


def test_students_can_open_the_found_address(monkeypatch: pytest.MonkeyPatch) -> None:
    assert own_address().count(".") == 3
    monkeypatch.setattr(address, "own_address", lambda: "10.0.0.5")
    assert find_address("https://duet.example.org", "127.0.0.1", 8080) == Address(
        "https://duet.example.org/", False
    )
    assert find_address("http://192.168.1.20:8080", "0.0.0.0", 8080).url == "http://192.168.1.20:8080/"
    assert find_address("http://localhost:8080", "0.0.0.0", 8080) == Address("http://10.0.0.5:8080/", False)
    assert find_address("http://127.0.0.1:81", "127.0.0.1", 81) == Address("http://127.0.0.1:81/", True)
    assert find_address("", "192.168.1.20", 81) == Address("http://192.168.1.20:81/", False)
    assert find_address("http://[::1]:81", "::1", 81) == Address("http://localhost:81/", True)
    # The option is one piece of code text, ready to type.
    assert "<code>--host 0.0.0.0</code>" in join_html(Address("http://127.0.0.1:81/", True))
    assert find_address("javascript:alert(1)", "127.0.0.1", 81).url == "http://127.0.0.1:81/"
    assert find_address("http://[", "127.0.0.1", 81).url == "http://127.0.0.1:81/"
    assert find_address("http://10.0.0.5:8080", "0.0.0.0", 8080).short == "10.0.0.5:8080/"
    monkeypatch.setattr(address, "own_address", lambda: "127.0.0.1")
    assert find_address("http://localhost:81", "0.0.0.0", 81).private, (
        "without a network the address is private"
    )


def test_the_qr_code_is_dark_on_white_with_its_quiet_zone() -> None:
    drawn = ElementTree.fromstring(qr_svg("http://192.168.1.20:8080/"))
    width = int(drawn.attrib["viewBox"].split()[2])
    # Version 2 has 25 modules, plus 4 quiet ones at each side.
    assert width == 25 + 2 * 4 and "width" not in drawn.attrib and drawn.attrib["role"] == "img"
    colours = {p.attrib.get("fill") or p.attrib.get("stroke") for p in drawn.iter() if p.tag.endswith("path")}
    assert colours >= {"#fff", PALETTES["light"].ink}
