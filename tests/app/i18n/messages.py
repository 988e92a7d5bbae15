"""Every text of the page for the catalogues.

Sources: arguments of `tr("…")`, also in templates, of `N_("…")`, and of functions that pass them to `tr`
or show them, such as `notify("…", "…")`; texts or templates of errors that may appear on the page, and of
other `LazyText`s; labels, hints and choices of settings; names of rows of buttons; and the tables below.
"""

import ast
import re
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Final

from jinja2 import Environment, nodes

import app
from app.features import FEATURES
from app.i18n.catalogue import FOLDER, catalogues, read_texts
from app.i18n.client_texts import ALL
from app.page.panels.controls import TABS
from app.page.panels.hotkeys import hotkeys
from app.plots.plot_choice import CHARTS
from app.plots.time_plots import TIME_PLOTS
from app.settings import LANGUAGES, TRANSLATIONS, Language, Settings
from app.text.law_texts import ALONE, LAW_TEXTS
from app.theme import SYMBOLS
from scenes.laws import LAWS
from scenes.quantities import FIRST_TASKS
from scenes.settings import leaves, specs

_APP: Final = Path(app.__file__).parent
_LETTERS: Final = re.compile(r"[^\W\d_]{2}")
_NO_TEXT: Final = re.compile(r"<[^>]*>|&\w+;|\{[^{}]*\}")
_SAID: Final = ("tr_html", "notify", "_notify", "News", "ChoiceButtons", "_stop_trouble")
"""Functions and classes that translate their arguments, in addition to `tr` and `N_`."""

_TELLING: Final = (
    "LazyText",
    "BadSetting",
    "BadInputFile",
    "BadFormula",
    "MissingPackage",
    "_fault",
    "_check",
    "Wrong",
)
"""Functions and classes with a text, or a template with its parts, as first argument."""

ON_THE_PAGE: Final = (
    *(
        "scenes/setting*.py",
        "scenes/rerun.py",
        "app/features/studies/counterexample.py",
        "scenes/run_text.py",
        "scenes/inputs_file*.py",
        "scenes/robots/*.py",
        "scenes/first_task/*.py",
    ),
    *("app/features/person_files/bvh*.py", "app/features/person_files/camera*.py"),
    *(
        "app/runtime/job_pool.py",
        "app/features/exports/*.py",
        "app/recording/*.py",
        "app/features/custom_law/[!c]*.py",
        "app/features/formula_law/*.py",
        *(f"app/features/marks/{name}.py" for name in ("fence", "isolation", "marked")),
        "app/page/**/*.py",
        "app/features/*/panel/*.py",
    ),
    # Input sources of the command line have errors of the command line.
    *("app/plots/*.py", "app/stage/*.py", "app/session/[!i]*.py"),
)
"""Files with errors that may appear on the page.

In all other files only templates with parts and `LazyText`s count; plain texts there are for the command line
and for authors of lessons.
"""

FORMULAS: Final = {
    *(
        "K",
        "v",
        "n",
        "g",
        "β",
        "γ",
        "η",
        "q̇",
        "a²",
        "ε",
        "dt",
        "d_m",
        "d_0",
        "h_m",
        "σ_m",
        "k_r",
        "w_max",
        "λ(d)",
        "e²(d)",
        "q₁–q₄",
    ),
    *("d ≥ d<sub>m</sub>", "u v w", "n, v"),
}
"""Labels that are symbols."""

NAMES: Final = {
    *(
        "Duet",
        "CSV",
        "HTML",
        "PNG",
        "SVG",
        "Python",
        *specs(Settings)["robot"].options().values(),
        *LANGUAGES.values(),
    ),
    *(
        "Pseudo (a test)",
        "Faverjon & Tournassoud 1987",
        "Khatib 1986",
        "Kanoun, Lamiraux & Wieber 2011",
        "Lee, Mansard & Park 2012",
        "Žlajpah & Nemec 2002",
    ),
    *(
        "Simetti & Casalino 2016",
        "Mansard, Remazeilles & Chaumette 2009",
        "Moe et al. 2016",
        "Mansard, Khatib & Kheddar 2009",
    ),
}
"""Names that are the same in every language."""


BODIES: Final = (
    *("upper arm", "elbow", "forearm", "wrist", "hand"),
    *("pedestal", "ball", "link", "outer link", "outer upper arm"),
)
"""Bodies of the pairs, as `app.plots.pair_strips` names them."""

JOINTS: Final = (
    *("base turn", "shoulder", "upper-arm roll", "elbow", "forearm roll", "wrist", "flange roll"),
    *("wrist bend", "wrist turn"),
    *(f"joint {i}" for i in range(1, 8)),
)

OTHERS: Final = (*("There is too little to measure yet; run it for a few seconds.", "decimal sign\x04."),)


@cache
def messages() -> dict[str, Path]:
    """Every English text of the page → folder of its catalogue, without formulas, numbers and symbols.

    Texts of the core are in the core's catalogue, those of features only in that of the lowest feature.
    """
    said: dict[str, set[Path]] = {}
    for path, found in (*_of_tables(), *_of_sources(), *_of_templates(), *_of_errors()):
        if _has_words(found):
            said.setdefault(found, set()).add(_catalogue_of(path))
    # The core is below all features, and the last feature of the tuple is the lowest.
    below = (FOLDER, *(feature.texts for feature in reversed(FEATURES) if feature.texts is not None))
    return {
        found: next(folder for folder in below if folder in places) for found, places in sorted(said.items())
    }


def _catalogue_of(path: Path) -> Path:
    """Folder of the catalogue for texts that only this file has."""
    texts = (feature.texts for feature in FEATURES if feature.texts is not None)
    return next((folder for folder in texts if path.is_relative_to(folder)), FOLDER)


def missing(language: Language) -> dict[str, Path]:
    """Texts without a translation in their catalogue → folder of that catalogue."""
    known = {path.parent: read_texts(path) for path in catalogues(language)}
    return {found: folder for found, folder in messages().items() if found not in known.get(folder, {})}


def left_over(language: Language) -> list[tuple[Path, str]]:
    """Catalogue and text of every unused translation, or of one in the wrong catalogue."""
    return [
        (path, text)
        for path in catalogues(language)
        for text in read_texts(path)
        if messages().get(text) != path.parent
    ]


def _has_words(found: str) -> bool:
    return found not in FORMULAS | NAMES and _LETTERS.search(_NO_TEXT.sub("", found)) is not None


def _of_tables() -> Iterator[tuple[Path, str]]:
    yield from ((FOLDER, found) for found in _of_the_cores_tables())


def _of_the_cores_tables() -> Iterator[str]:
    # Choices of features are texts of the features.
    for _, spec in leaves(Settings).values():
        yield from (spec.label, spec.words, spec.help, *spec.options().values())
    yield from (name for name, _, _ in TABS)
    yield from (hotkey.text for hotkey in hotkeys())
    for course in TIME_PLOTS.values():
        yield from (course.title, *(line.name for line in course.lines if line.name))
    yield from (symbol.sentence for symbol in SYMBOLS.values())
    yield ALONE[1]
    yield from (law.short for law in LAWS.values())
    yield from (first.short for first in FIRST_TASKS.values())
    for texts in LAW_TEXTS.values():
        yield from (texts.source, texts.share, texts.consequence, texts.acting, texts.missed, *texts.trends)
        yield from re.findall(r"\\text\{\{(.+?)\}\}", "".join(texts.equation))
    yield from map(str, CHARTS.values())
    yield from (*BODIES, *JOINTS, *OTHERS, *ALL)


@cache
def _read(path: Path) -> tuple[ast.Module, list[ast.Call]]:
    """A file's syntax tree and its calls."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return tree, [node for node in ast.walk(tree) if isinstance(node, ast.Call)]


def _of_sources(folder: Path = _APP) -> Iterator[tuple[Path, str]]:
    files = {path: _read(path) for path in sorted(folder.rglob("*.py"))}
    named = {name: value for tree, _ in files.values() for name, value in _constants(tree)}
    passed_on = {found for file in files.values() for found in _passed_on(*file)}
    for path, (tree, calls) in files.items():
        here = (*_SAID, *(_imported(tree) & {"tr", "N_"}))
        for node in calls:
            if _name(node.func) in here:
                given = (*node.args, *(keyword.value for keyword in node.keywords))
                yield from ((path, found) for found in _texts(given, named))
            else:
                for _, place, parameter in (found for found in passed_on if found[0] == _name(node.func)):
                    given = [keyword.value for keyword in node.keywords if keyword.arg == parameter]
                    arguments = (*node.args[place : place + 1], *given)
                    yield from ((path, found) for found in _texts(arguments, named))


def _passed_on(tree: ast.Module, calls: list[ast.Call]) -> Iterator[tuple[str, int, str]]:
    """Name of a function, position and name of its parameter, for each parameter passed to `tr` unchanged."""
    if not any(_name(call.func) in ("tr", "tr_html") and call.args and _name(call.args[0]) for call in calls):
        return
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef):
            parameters = [argument.arg for argument in function.args.args if argument.arg != "self"]
            for node in ast.walk(function):
                if isinstance(node, ast.Call) and _name(node.func) in ("tr", "tr_html") and node.args:
                    given = _name(node.args[0])
                    if given in parameters:
                        yield function.name, parameters.index(given), given


def _of_templates() -> Iterator[tuple[Path, str]]:
    reader = Environment()
    for path in sorted(_APP.rglob("*.html")):
        for call in reader.parse(path.read_text(encoding="utf-8")).find_all(nodes.Call):
            if isinstance(call.node, nodes.Name) and call.node.name in ("tr", "tr_html", "words"):
                # A literal text, or one of two.
                texts = (text for given in call.args for text in (given, *given.find_all(nodes.Const)))
                constants = (text.value for text in texts if isinstance(text, nodes.Const))
                yield from ((path, text) for text in constants if isinstance(text, str))


def on_the_page() -> Iterator[Path]:
    for pattern in ON_THE_PAGE:
        yield from sorted(_APP.parent.glob(pattern))


def errors_of(path: Path, plain: bool = True) -> Iterator[ast.expr]:
    """Text of every call that makes an error or a `LazyText`. `plain`: also errors without parts."""
    for node in _read(path)[1]:
        if (name := _name(node.func)) in _TELLING:
            # The first argument of `_check` is the checked value.
            first = node.args[name == "_check" : 2]
            if first and (plain or node.keywords or name == "LazyText"):
                yield first[0]


def _of_errors() -> Iterator[tuple[Path, str]]:
    here = {*on_the_page()}
    for floor in ("controllers", "scenes", "app"):
        for path in (_APP.parent / floor).rglob("*.py"):
            yield from ((path, found) for found in _texts(errors_of(path, path in here), {}))


def _imported(tree: ast.Module) -> set[str]:
    found = (
        node for node in tree.body if isinstance(node, ast.ImportFrom) and node.module == "app.i18n.speaking"
    )
    return {alias.name for node in found for alias in node.names}


def _name(node: ast.expr) -> str:
    return node.id if isinstance(node, ast.Name) else node.attr if isinstance(node, ast.Attribute) else ""


def _constants(tree: ast.Module) -> Iterator[tuple[str, ast.expr]]:
    """Names and values of the module's constants."""
    for node in tree.body:
        target = (
            node.target
            if isinstance(node, ast.AnnAssign)
            else node.targets[0]
            if isinstance(node, ast.Assign)
            else None
        )
        if (
            isinstance(target, ast.Name)
            and isinstance(node, (ast.AnnAssign, ast.Assign))
            and node.value is not None
        ):
            yield target.id, node.value


def _texts(nodes: Iterable[ast.expr], named: dict[str, ast.expr], deep: bool = True) -> Iterator[str]:
    """Texts among expressions: literals, one of two, several, or by the name of a constant."""
    for node in nodes:
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value
        elif isinstance(node, (ast.Tuple, ast.List)):
            yield from _texts(node.elts, named, deep)
        elif isinstance(node, ast.Dict):
            yield from _texts(filter(None, node.keys), named, deep)
        elif isinstance(node, ast.IfExp):
            yield from _texts((node.body, node.orelse), named, deep)
        elif isinstance(node, ast.Name) and deep and node.id in named:
            yield from _texts((named[node.id],), named, deep=False)
        elif isinstance(node, ast.Call) and _name(node.func) == "text":
            yield from _texts(node.args, named, deep)


if __name__ == "__main__":
    for language in TRANSLATIONS:
        for found, folder in missing(language).items():
            print(folder / f"{language}.toml", repr(found))
