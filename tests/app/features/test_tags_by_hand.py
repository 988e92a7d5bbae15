"""No file joins tags by hand: templates make HTML."""

import ast
import re

from tests.test_imports import ROOT

TAG = re.compile(r"(?<!\?P)<[a-zA-Z][\w-]*(?=[\s>/{]|$)")

BY_HAND = {"app/page/panels/distance_rate.py": 1, "app/web/pages.py": 1}
"""File → number of texts with several tags: a symbol sent ten times a second; and a part of viser's page,
in a folder below the templates."""


def joined_by_hand(source: str) -> list[str]:
    """Texts with several tags, and elements in elements, except translated texts."""
    nodes, found = list(ast.walk(ast.parse(source))), list[str]()
    translated = {
        id(part)
        for call in nodes
        if isinstance(call, ast.Call) and ast.unparse(call.func) in ("tr", "tr_html", "N_")
        for given in call.args
        for part in ast.walk(given)
    }
    parts = {id(part) for text in nodes if isinstance(text, ast.JoinedStr) for part in text.values}
    documented = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    for node in nodes:
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "element":
            inner = [one for given in node.args for one in ast.walk(given)]
            if any(isinstance(one, ast.Call) and ast.unparse(one.func) == "element" for one in inner):
                found.append(ast.unparse(node))
        elif (
            isinstance(node, (ast.JoinedStr, ast.Constant))
            and id(node) not in translated | parts | documented
        ):
            values = node.values if isinstance(node, ast.JoinedStr) else [node]
            words = "{}".join(
                str(one.value)
                for one in values
                if isinstance(one, ast.Constant) and isinstance(one.value, str)
            )
            if len(TAG.findall(words)) > 1:
                found.append(ast.unparse(node))
    return found


def test_no_file_joins_tags_by_hand_except_in_a_short_list() -> None:
    found = {
        path.relative_to(ROOT).as_posix(): texts
        for floor in ("app", "scenes", "controllers")
        for path in sorted((ROOT / floor).rglob("*.py"))
        if (texts := joined_by_hand(path.read_text(encoding="utf-8")))
    }
    assert {name: len(texts) for name, texts in found.items()} == BY_HAND, found


def test_positive_control_tags_joined_by_hand_are_found() -> None:
    for source in ('"<p><b>x</b></p>"', 'f"<p>{x}<b>{y}</b></p>"', 'element("p", "", element("b", "x"))'):
        assert joined_by_hand(f"y = {source}") != []
    for source in (
        '"<b>x</b>"',
        'f"<p>{x}</p>"',
        'element("p", "x")',
        'tr("<b>d<sub>m</sub></b>")',
        '"a < b"',
    ):
        assert joined_by_hand(f"y = {source}") == []
