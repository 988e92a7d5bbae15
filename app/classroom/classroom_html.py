"""What the class sees and what the teacher sees, as HTML: histogram, notes, address, and what is said to a student."""

import html
from pathlib import Path
from typing import Final

from app.classroom.address import Address, qr_svg
from app.classroom.classroom import Headcount, Poll
from app.i18n.speaking import N_, tr
from app.lessons.notes import Notes, StepNotes
from app.text.lesson_text import inline_html, lesson_html

FOLLOWING: Final = N_("You follow the teacher: everybody sees this stage.")
EXPLORING: Final = N_("Explore freely: this is your own session, nobody else's. Your settings are kept for the next time.")
WATCHING: Final = N_("All {most} places for exploring are taken, so you go on watching. As soon as one is free, it is yours.")
NAMELESS: Final = N_("Your browser keeps no data of this page, so you cannot have a session of your own and go on watching.")
HALTED: Final = N_("The teacher has paused everybody.")
"""What is said at the top of a student's page."""


def poll_html(poll: Poll, mine: int | None = None, live: bool = False) -> str:
    """Return the histogram of the class's answers; once the outcome is known, with what was measured beside it.

    Args:
        poll: the question.
        mine: the answer of whoever looks.
        live: whether it is the teacher's, before the reveal.
    """
    tally = poll.tally
    rows = "".join(_row(poll, i, i == mine) for i in range(len(poll.choices)))
    title = tr("The class says") if live else tr("The class said")
    count = tr("{count} answered", count=tally.answered)
    if live:
        count += " · " + tr("{count} not yet", count=tally.waiting)
    # The first line is the question's; the verdict below has all of them.
    footer = f"<footer><span>{tr('Measured')}</span><p>{html.escape(poll.outcome[0])}</p></footer>" if poll.outcome else ""
    return f'<div class="duet-poll"><header><b>{title}</b><span>{count}</span></header><ol>{rows}</ol>{footer}</div>'


def _row(poll: Poll, index: int, mine: bool) -> str:
    count, answered = poll.tally.counts[index], poll.tally.answered
    share = round(100.0 * count / answered) if answered else 0
    kinds = " ".join(name for name, true in (("right", poll.right == index), ("mine", mine)) if true)
    percent = f"<small>{share} %</small>" if answered else ""
    return (
        f'<li class="{kinds}"><i>{index + 1}</i><span>{inline_html(poll.choices[index])}</span><b>{count}{percent}</b>'
        f'<div aria-hidden="true"><div style="width:{share}%"></div></div></li>'
    )


def heads_html(heads: Headcount, free: bool, paused: bool, waiting: int) -> str:
    """Return how many are here and what they do. `waiting`: how many want to explore and have no place."""
    pills = [f"<span>{tr('students here: {count}', count=heads.all)}</span>"]
    if free:
        pills.append(f'<span class="go">{tr("exploring: {count}", count=heads.exploring)}</span>')
        if waiting:
            pills.append(f'<span class="halt">{tr("without a place: {count}", count=waiting)}</span>')
    elif heads.all:
        pills.append(f'<span class="go">{tr("all follow")}</span>')
    if paused:
        pills.append(f'<span class="halt">{tr("everybody is paused")}</span>')
    return f'<div class="duet-class duet-lesson"><div class="duet-heads" role="status">{"".join(pills)}</div></div>'


def banner_html(kind: str, text: str) -> str:
    """Return what is said to a student above everything else."""
    return f'<div class="duet-banner {kind} duet-say">{html.escape(text)}</div>' if text else ""


def notes_html(notes: Notes, step: int, folder: Path | None = None) -> str:
    """Return the teacher's notes to a lesson: to the present step first.

    Args:
        notes: of the lesson.
        step: the present one, from 1.
        folder: where its pictures are.
    """
    now = "".join(_section_html(part, folder, "now") for part in notes.steps if part.number == step)
    others = "".join(_section_html(part, folder) for part in notes.steps if part.number != step)
    head = f"<h3>{inline_html(notes.title)}</h3>" if notes.title else ""
    return f'<div class="duet-class duet-notes">{now}{head}{lesson_html(notes.text, folder)}{others}</div>'


def _section_html(part: StepNotes, folder: Path | None, kind: str = "") -> str:
    title = f"{part.number}. {part.title}" if part.title else f"{part.number}."
    return f'<section class="{kind}"><h4>{inline_html(title)}</h4>{lesson_html(part.text, folder)}</section>'


def no_notes_html(open: bool) -> str:
    """Return what stands where no notes are."""
    said = (
        tr("This lesson has no notes.")
        if open
        else tr("Open a lesson: its notes for the teacher are then here, and on no student's page.")
    )
    return f'<div class="duet-class"><p class="soft">{said}</p></div>'


def join_html(address: Address) -> str:
    """Return the address for the teacher."""
    if address.private:
        told = tr("Only this computer can open it. Start with --host 0.0.0.0 to let the class in.")
    else:
        told = tr(
            "Students type it, or point a camera at the code. For the projector open {link}: it shows everything and is no student.",
            link=f"{address.short}?screen=1",
        )
    warning = f'<p class="soft">{html.escape(told)}</p>'
    return (
        f'<div class="duet-class duet-lesson"><div class="duet-join"><div><p><b class="url">{html.escape(address.short)}</b></p></div>'
        f"{qr_svg(address.url, tr('QR code of the address'))}</div>{warning}</div>"
    )


def overlay_html(address: Address) -> str:
    """Return the address for everybody's screen."""
    return (
        '<div class="duet-overlay"><section><button type="button" aria-label="'
        f'{tr("Close")}">✕</button><h2>{tr("Join the class")}</h2>'
        f"{qr_svg(address.url, tr('QR code of the address'))}"
        f'<div class="url">{html.escape(address.short)}</div><p>{tr("Point your camera at the code, or type the address.")}</p>'
        "</section></div>"
    )


def mine_html(poll: Poll, mine: int | None) -> str:
    """Return what is said to a student about their own answer."""
    if poll.verdicts:
        return _verdict_html(poll, mine)
    if mine is None:
        ask = tr("Your prediction? Answer here, or with the keys 1 to {count}.", count=len(poll.choices))
        said = ask if poll.open else tr("Answers are closed.")
        return f'<div class="duet duet-lesson"><p class="mine duet-say">{said}</p></div>'
    until = tr("You may change it until the reveal.") if poll.open else tr("Answers are closed.")
    return (
        f'<div class="duet duet-lesson"><p class="mine duet-say">{tr("Your prediction:")} '
        f"<b>{inline_html(poll.choices[mine])}</b>. {until}</p></div>"
    )


def _verdict_html(poll: Poll, mine: int | None) -> str:
    verdict = poll.verdicts[mine] if mine is not None else None
    measured = "".join(f"<p>{html.escape(line)}</p>" for line in poll.outcome)
    if verdict is None or mine is None:
        return (
            f'<div class="duet duet-lesson"><div class="card duet-say"><b>{tr("Measured in this run")}</b>{measured}</div></div>'
        )
    mark, kind = ("✓", "right") if verdict.right else ("↺", "wrong")
    return (
        f'<div class="duet duet-lesson"><div class="card {kind} duet-say"><p class="mark"><span>{mark}</span> '
        f"<b>{html.escape(verdict.headline)}</b></p><dl><dt>{tr('You said')}</dt><dd>{inline_html(poll.choices[mine])}</dd>"
        f"<dt>{tr('Measured')}</dt><dd>{measured}</dd></dl>{lesson_html(verdict.reply)}</div></div>"
    )
