"""A student's banner, and the address with its QR code."""

from typing import Final

from markupsafe import Markup

from app.i18n.speaking import N_, tr
from app.text.templates import element, macros, tr_html
from app.web.address import Address, qr_svg

WATCHING: Final = N_("Another member of your group has control.")
TAKE_OVER: Final = N_("Take over")


def banner_html(kind: str, text: str) -> Markup:
    return element("div", text, class_=f"duet-banner {kind} duet-say") if text else Markup()


def join_html(address: Address) -> Markup:
    if address.private:
        hint = tr_html(
            "Only this computer can open it. Start with <code>--host 0.0.0.0</code> to admit the class."
        )
    else:
        hint = tr(
            "Students type it, or point a camera at the code. {link} is for a projector, without a clicker; it is not counted.",
            link=f"{address.short}?screen=1",
        )
    return macros("features/lecture/invitation.html").join(
        address, hint, qr_svg(address.url, tr("QR code of the address"))
    )


def overlay_html(address: Address, joined: tuple[int, int] | None = None) -> Markup:
    """Address for every screen. `joined`: see `joined_text`."""
    said = "" if joined is None else joined_text(*joined)
    return macros("features/lecture/invitation.html").overlay(
        address, qr_svg(address.url, tr("QR code of the address")), said
    )


def joined_text(here: int, expected: int) -> str:
    """Number of present students, and of `expected` ones unless that is 0."""
    return (
        tr("{count} of {expected} are in", count=here, expected=expected)
        if expected
        else tr("{count} are in", count=here)
    )
