"""The list of lessons as HTML."""

from collections.abc import Iterable, Mapping
from html import escape

from app.i18n.speaking import tr
from app.lessons.lesson_list import LessonEntry
from app.text.lesson_text import inline_html


def lesson_list_html(entries: Iterable[LessonEntry], buttons: Mapping[str, str]) -> str:
    """Return the list.

    Args:
        buttons: lesson id → id of the element that opens it; empty for readers who open nothing.
    """
    cards = "".join(f"<li>{_card(entry, buttons.get(entry.lesson.id, ''))}</li>" for entry in entries)
    # The list's own buttons stand for these.
    hidden = "".join(f'div:has(> [id="{escape(button)}"]){{display:none}}' for button in buttons.values())
    head = f'<h2>{tr("Lessons")}</h2><p class="crumb">{tr("After each one you can …")}</p>'
    return f'<style>{hidden}</style>{head}<ol class="lessons">{cards}</ol>'


def _card(entry: LessonEntry, button: str) -> str:
    lesson, count = entry.lesson, sum(entry.finished)
    whole = all(entry.finished)
    state = tr("{count} of {all} steps finished", count=count, all=len(entry.finished))
    ticks = "".join(f'<i class="{"ok" if one else ""}">{"✓" if one else ""}</i>' for one in entry.finished)
    here = f"<em>{tr('continue')}</em>" if entry.here else ""
    text = (
        f'<span class="no">{"✓" if whole else lesson.number}</span><span class="what"><b>{inline_html(lesson.title)}</b>{here}'
        f"<span>{inline_html(lesson.promise or lesson.goal)}</span>"
        f"<small>{tr('{minutes} min', minutes=lesson.minutes)}"
        f'<span class="ticks" role="img" aria-label="{escape(state)}">{ticks}</span></small></span>'
    )
    kind = f"lesson{' whole' if whole else ''}{' here' if entry.here else ''}"
    if not button:
        return f'<div class="{kind}">{text}</div>'
    return f'<button type="button" class="{kind}" data-duet-presses="{escape(button)}">{text}</button>'
