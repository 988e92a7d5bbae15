"""The document on writing lessons: listed with the others, and with the lessons' licence."""

from app.features.lessons.folder import FOLDER
from app.text.document_list import DOCUMENTS
from app.text.documents import document_html


def test_the_writing_guide_is_linked_from_and_to_other_documents() -> None:
    assert DOCUMENTS["lessons"].file == FOLDER / "README.md"
    assert '<a href="lessons">' in document_html("[l](../features/lessons/files/README.md)")
    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert "CC BY 4.0" in text and '<a href="cite">' in document_html(text)
