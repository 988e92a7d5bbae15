"""The documents for teachers, as the server sends them."""

import re
import tomllib
import urllib.error
import urllib.request
from collections.abc import Callable

import pytest

from app.i18n.catalogue import words_of
from app.text.document_list import DOCUMENTS
from app.text.documents import document_html, document_page
from app.text.lesson_text import lesson_html
from tests.app.conftest import OpenHouse
from tests.app.html_reader import HtmlReader
from tests.app.i18n.conftest import untranslated
from tests.test_imports import ROOT


@pytest.mark.parametrize("name", DOCUMENTS)
def test_every_document_is_complete_with_valid_links(name: str) -> None:
    read = HtmlReader(document_page(name).decode())
    # No resource comes from another server, and all links on this server exist.
    here = {link for link in read.links if not link.startswith(("https://", "data:"))}
    assert here <= {"../", *DOCUMENTS}
    title = DOCUMENTS[name].file.read_text(encoding="utf-8").splitlines()[0].removeprefix("# ")
    assert title.replace("`", "") in read.text


@pytest.mark.parametrize("name", DOCUMENTS)
def test_the_frame_of_a_document_is_in_the_readers_language(name: str) -> None:
    page = document_page(name, "pseudo").decode()
    frame = page[: page.index("<main")] + page[page.index("</main>") :]
    assert '<html lang="en">' in page and '<main lang="en">' in page
    assert untranslated(re.sub(r"<style>.*?</style>", "", frame, flags=re.DOTALL)) == []
    german = document_page(name, "de").decode()
    assert '<html lang="de">' in german and words_of("de")(DOCUMENTS[name].title) in german
    assert 'lang="en"' not in document_page(name).decode().split("<main")[1]


def test_formulas_tables_and_numbers_of_equations() -> None:
    page = document_page("model").decode()
    assert page.count("<svg") > 20 and "<table>" in page and "(30, 32, 33)" in page
    assert "$" not in re.sub("<svg.*?</svg>", "", page)


@pytest.mark.parametrize("render", [document_html, lesson_html])
@pytest.mark.parametrize(
    ("text", "made"),
    [
        ("`$a$` <b onclick=x>b</b>", "<p><code>$a$</code> &lt;b onclick=x&gt;b&lt;/b&gt;</p>"),
        ("```sh\necho $HOME $HOME\n```", '<pre><code class="language-sh">echo $HOME $HOME\n</code></pre>'),
        ("so:\n\n    return 1\n    return 2", "<p>so:</p>\n<pre><code>return 1\nreturn 2\n</code></pre>"),
        ("so\n- a *b*\n- c", "<p>so</p>\n<ul>\n<li>a <em>b</em></li>\n<li>c</li>\n</ul>"),
        ("[a](javascript:x) ![b](http://c)", "<p>[a](javascript:x) !<a>b</a></p>"),
        ("[toml](https://toml.io)", "<p><a>toml</a></p>"),
        ("a\n$$x\n- y$$\nb", '<p>a</p>\n<div class="duet-formula"><svg></div><p>b</p>'),
        (
            "a $$x \\tag{3}$$ b",
            '<p>a <span class="duet-formula"><svg><span class="no">(3)</span></span> b</p>',
        ),
        ("a\n![b](c.svg)\nd", "<p>a</p>\n<p>b</p><p>d</p>"),
    ],
)
def test_documents_and_lessons_have_the_same_renderer(
    render: Callable[[str], str], text: str, made: str
) -> None:
    html = re.sub("<svg.*?</svg>", "<svg>", str(render(text)), flags=re.DOTALL)
    assert re.sub(r'<a href="https?://[\w.]+" target="_blank" rel="noopener">', "<a>", html).strip() == made


def test_links_to_documents_work_only_in_documents() -> None:
    assert '<a href="model">' in document_html("[m](model.md)")
    assert "<a" not in lesson_html("[m](model.md)") + document_html("[m](other.md)")


def test_the_server_sends_the_documents(house: OpenHouse) -> None:
    url = house().url
    with urllib.request.urlopen(f"{url}/documents/model", timeout=60) as answer:
        assert answer.read() == document_page("model")
    with pytest.raises(urllib.error.HTTPError, match="404"):
        urllib.request.urlopen(f"{url}/documents/10-limits.notes", timeout=60)


def test_the_citation_has_this_version_and_the_readme_both_licences() -> None:
    text = DOCUMENTS["cite"].file.read_text(encoding="utf-8")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert re.findall(r"version = \{(.*?)\}", text) == [project["version"]]
    entries = dict(re.findall(r"^@(\w+)\{(\w+),$", text, re.MULTILINE))
    # Both entries are complete: equally many opening and closing braces.
    assert set(entries) == {"software", "inproceedings"} and text.count("{") == text.count("}")
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert "CC BY 4.0" in readme and "cite.md" in readme
