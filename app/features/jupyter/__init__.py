from pathlib import Path
from typing import Final

from app.feature import Feature
from app.i18n.speaking import N_
from app.text.document_list import DocumentFile

_HERE: Final = Path(__file__).parent

_DOCUMENTS: Final = {"jupyter": DocumentFile(_HERE / "jupyter.md", N_("In Jupyter"))}

JUPYTER: Final = Feature("jupyter", texts=_HERE, documents=_DOCUMENTS)
