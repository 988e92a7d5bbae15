"""A link with &amp; in the browser is repaired for all scripts of the page."""

from playwright.sync_api import Browser

from app.web.pages import STATIC

PAGE = '<script>"use strict"; window.duet = {{}};\n{}</script>'.format(
    (STATIC / "page_query.js").read_text(encoding="utf-8")
)


def test_the_scripts_of_the_page_read_a_repaired_link(browser: Browser) -> None:
    tab = browser.new_page()
    try:
        tab.route("**/*", lambda route: route.fulfill(body=PAGE, content_type="text/html"))
        for link, mended in (
            ("?rig=table&amp;dm=0.1&amp%3Bamp;lang=de#x", "?rig=table&dm=0.1&lang=de#x"),
            ("?rig=table&dm=0.1", "?rig=table&dm=0.1"),
            ("?name=a%26amp%3Bb", "?name=a%26amp%3Bb"),
        ):
            tab.goto(f"http://duet.test/folder/{link}")
            assert tab.evaluate("location.href") == f"http://duet.test/folder/{mended}"
    finally:
        tab.close()
