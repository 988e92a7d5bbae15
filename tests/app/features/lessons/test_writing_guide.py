"""The document on writing lessons: it is offered with the others, and says under which licence lessons are."""

from app.features.lessons.folder import FOLDER
from app.text.document_list import DOCUMENTS
from app.text.documents import document_html


def test_it_is_a_document_to_which_others_lead_and_which_leads_to_them() -> None:
    assert DOCUMENTS["lessons"].file == FOLDER / "README.md"
    assert '<a href="lessons">' in document_html("[l](../features/lessons/files/README.md)")
    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert "CC BY 4.0" in text and '<a href="cite">' in document_html(text)
