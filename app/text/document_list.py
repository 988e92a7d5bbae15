"""The page's documents; `app.text.documents` renders them."""

from collections.abc import Mapping
from pathlib import Path
from typing import Final, NamedTuple

from app.i18n.speaking import N_

_APP: Final = Path(__file__).parents[1]


class DocumentFile(NamedTuple):
    """A document; `title`: English, for `tr`."""

    file: Path
    title: str


DOCUMENTS: Final[dict[str, DocumentFile]] = {
    name: DocumentFile(_APP / file, title)
    for name, file, title in (
        ("page", "documents/page.md", N_("The page")),
        ("model", "documents/model.md", N_("The model")),
        ("commands", "documents/commands.md", N_("Without a page")),
        ("accessibility", "documents/accessibility.md", N_("Accessibility")),
        ("cite", "documents/cite.md", N_("How to cite, and licences")),
        ("code", "documents/code.md", N_("The code")),
        ("recipes", "documents/recipes.md", N_("Recipes")),
        ("examples", "documents/examples.md", N_("Examples")),
        ("decisions", "documents/decisions.md", N_("Decisions")),
        ("changes", "documents/changes.md", N_("Changes")),
    )
}

_AFTER: Final = "commands"


def add_documents(documents: Mapping[str, DocumentFile]) -> None:
    known = {name: one for name, one in DOCUMENTS.items() if name not in documents}
    DOCUMENTS.clear()
    for name, one in known.items():
        DOCUMENTS[name] = one
        if name == _AFTER:
            DOCUMENTS.update(documents)
