"""What the last lesson says of the student's own law: how to begin, the six tests as they come, and what is wrong with the file."""

from html import escape
from typing import Final

from app.custom_law.examination import ExaminationProgress
from app.custom_law.trials import TRIALS, WHY
from app.i18n.speaking import tr

COMMANDS: Final = ("lwr-duet new-law my_law.py", "lwr-duet serve --law-file my_law.py")
"""What has to be typed to have a law of one's own on the page."""


def law_html(progress: ExaminationProgress, problem: str, away: bool, passed: bool) -> str:
    """Return the block of the step.

    Args:
        progress: of the tests.
        problem: why the arm stands still; "" if all is well.
        away: whether the file is gone.
        passed: whether the challenge was ever passed.
    """
    star = f'<p class="mark"><span>★</span> <b>{tr("Challenge passed.")}</b></p>' if passed else ""
    if progress.file is None:
        return f'<div class="duet duet-lesson duet-l-attempt"><div class="card why">{star}{beginning_html()}</div></div>'
    return f'<div class="duet duet-lesson duet-l-attempt">{file_html(progress.file, problem, away)}{tests_html(progress, star)}</div>'


def beginning_html() -> str:
    """Return what has to be done where the server was started without a file."""
    first, second = (f"<pre>{escape(command)}</pre>" for command in COMMANDS)
    return (
        f"<p><b>{tr('Your law stands in a file of your own.')}</b></p>"
        f"<p>{tr('In a terminal, this writes one to begin with, the paper’s law in a few lines:')}</p>{first}"
        f"<p>{tr('End this server (Ctrl+C), and start it again with your file:')}</p>{second}"
        f"<p>{tr('Then open this step again. Whatever you save runs at once, and a button here tests it.')}</p>"
        f"<p>{tr('Files are not taken from the page: they are programs, and would run on the computer that serves it.')}</p>"
    )


def file_html(file: str, problem: str, away: bool) -> str:
    """Return whether the file's law runs, and if not, why: a message with its line."""
    name = escape(file)
    if away:
        gone = tr("{file} is gone.", file=name)
        goes_on = tr("What it said last runs on. Save it again under this name.")
        return f'<div class="card wrong law duet-say" role="status"><p><b>{gone}</b> {goes_on}</p></div>'
    if not problem:
        runs = tr("{file} runs.", file=name)
        return f'<div class="card right law" role="status"><p><b>{runs}</b> {tr("Save it, and the arm follows.")}</p></div>'
    what = f'<p class="what">{escape(tr(problem))}</p>'
    return (
        f'<div class="card wrong law duet-say" role="status"><p class="mark"><span aria-hidden="true">⚠</span> '
        f"<b>{tr('{file} does not run: its arm stands still.', file=name)}</b></p>{what}"
        f"<p>{tr('Mend it and save; it is loaded again by itself.')}</p></div>"
    )


def tests_html(progress: ExaminationProgress, star: str) -> str:
    """Return all six tests, each with how it went, in words."""
    if progress.message:
        return f'<div class="card wrong duet-say" role="status"><p>{escape(tr(progress.message))}</p></div>'
    begun = progress.running or progress.finished
    known = {verdict.name: verdict for verdict in progress.verdicts}
    entries: list[str] = []
    now = True
    for name in TRIALS:
        verdict = known.get(name)
        if verdict is not None:
            kind, mark, word = ("ok", "✓", tr("passed")) if verdict.passed else ("no", "✗", tr("failed"))
            text = escape(tr(verdict.reason)) + ("" if verdict.passed else f" <i>{tr(WHY[name])}</i>")
        elif progress.running and now:
            kind, mark, word, text, now = "now", "…", tr("being tested"), "", False
        else:
            kind, mark, word, text = "", "○", tr("waits") if begun else "", "" if begun else tr(WHY[name])
        word = f" <em>{word}</em>" if word else ""
        entries.append(
            f'<li class="{kind}"><span aria-hidden="true">{mark}</span><div><b>{tr(name)}</b>{word}<p>{text}</p></div></li>'
        )
    listed = f'<ol class="tests">{"".join(entries)}</ol>'
    count = sum(verdict.passed for verdict in progress.verdicts)
    said = tr("{count} of {all} tests passed.", count=count, all=len(TRIALS))
    if not progress.finished:
        head = tr("Six tests") if not begun else tr("Test {number} of {all} …", number=len(known) + 1, all=len(TRIALS))
        return f'<div class="card law" role="status"><p class="duet-say"><b>{head}</b></p>{star}{listed}</div>'
    kind = "right" if count == len(TRIALS) else "wrong"
    return f'<div class="card {kind} law" role="status">{star}<p class="duet-say"><b>{said}</b></p>{listed}</div>'
