"""HTML of a lecture: the histogram, the headcount, the address, and the lines on a student's page."""

from typing import Final

from app.classroom.address import Address, qr_svg
from app.classroom.classroom import Classroom, Poll
from app.export.tally_html import bars_html, cloud_html, switches_text, tie_text
from app.i18n.speaking import N_, spoken, tr
from app.lessons.curve_drawing import drawing_svg, judge_drawing
from app.lessons.tally import Ballot
from app.page.lessons.lesson_html import drawing_verdict_html
from app.page.panels.server_load import load_html
from app.text.html_element import element
from app.text.lesson_text import inline_html, lesson_html

FOLLOWING: Final = N_("You follow the teacher: everybody sees this stage.")
EXPLORING: Final = N_("Explore freely: this is your own session, and its settings are kept for the next time.")
WATCHING: Final = N_("All {most} places for exploring are taken, so you go on watching. As soon as one is free, it is yours.")
NAMELESS: Final = N_("Your browser blocks storage for this page, so you can only watch.")
HALTED: Final = N_("The teacher has paused everybody.")
"""Banner of a student's page."""

_NONE: Final = Ballot()


def poll_html(poll: Poll, mine: int | None = None, live: bool = False) -> str:
    """Return the histogram of the class's answers, and its curves as a cloud; once the outcome is known, with the measured result.

    Args:
        mine: the reader's own answer.
        live: whether it is the teacher's, before the reveal.
    """
    tally = poll.tally
    title = tr("The class says") if live else tr("The class said")
    count = tr("{count} answered", count=tally.answered)
    if live:
        count += " · " + tr("{count} not yet", count=tally.waiting)
    # The first line answers the question; the verdict below has all of them.
    footer = [element("footer", "", element("span", tr("Measured")), element("p", poll.outcome[0]))] if poll.outcome else []
    head = element("header", "", element("b", title), element("span", count))
    rounds = ([] if poll.first is None else [(1, poll.first)]) + [(poll.round, tally)]
    bars = bars_html(poll.choices, rounds, poll.right, mine)
    words = [element("p", text, class_="said") for text in (_tie(poll), switches_text(poll.switches, poll.right)) if text]
    cloud = cloud_html(poll.drawing, rounds, poll.truth)
    return element("div", "", head, cloud, bars, *words, *footer, class_="duet-poll")


def _tie(poll: Poll) -> str:
    """Return what is said to a tie, after the reveal with the answer that the run is compared with."""
    text = tie_text(poll.tally)
    if not text or not poll.revealed or poll.staged is None:
        return text
    return f"{text} {tr('The run is compared with answer {number}.', number=poll.staged + 1)}"


def heads_html(room: Classroom) -> str:
    """Return how many students there are, what they do, and how busy the server is."""
    present, exploring = room.heads
    pills = [element("span", tr("students here: {count}", count=present))]
    if room.free:
        pills.append(element("span", tr("exploring: {count}", count=exploring), class_="go"))
        if room.waiting:
            pills.append(element("span", tr("without a place: {count}", count=room.waiting), class_="halt"))
    elif present:
        pills.append(element("span", tr("all follow"), class_="go"))
    if room.work.hand_ins:
        pills.append(element("span", tr("reports handed in: {count}", count=len(room.work.hand_ins)), class_="go"))
    if room.paused:
        pills.append(element("span", tr("everybody is paused"), class_="halt"))
    heads = [element("div", "", *pills, class_="duet-heads", role="status")]
    if room.load is not None:
        heads.append(element("div", "", load_html(room.load), class_="duet-heads"))
    return element("div", "", *heads, class_="duet-class duet-lesson")


def banner_html(kind: str, text: str) -> str:
    """Return the banner of a student's page; "" for no text."""
    return element("div", text, class_=f"duet-banner {kind} duet-say") if text else ""


def join_html(address: Address) -> str:
    """Return the address for the teacher."""
    if address.private:
        hint = tr("Only this computer can open it. Start with --host 0.0.0.0 to let the class in.")
    else:
        hint = tr(
            "Students type it, or point a camera at the code. {link} is for a projector, without a clicker; it is not counted.",
            link=f"{address.short}?screen=1",
        )
    text = element("div", "", element("p", "", element("b", address.short, class_="url")))
    join = element("div", "", text, _qr_code(address), class_="duet-join")
    return element("div", "", join, element("p", hint, class_="soft"), class_="duet-class duet-lesson")


def overlay_html(address: Address) -> str:
    """Return the address for every screen."""
    section = element(
        "section",
        "",
        element("button", "✕", type="button", aria_label=tr("Close")),
        element("h2", tr("Join the class")),
        _qr_code(address),
        element("div", address.short, class_="url"),
        element("p", tr("Point your camera at the code, or type the address.")),
    )
    return element("div", "", section, class_="duet-overlay")


def _qr_code(address: Address) -> str:
    return qr_svg(address.url, tr("QR code of the address"))


def mine_html(poll: Poll, ballot: Ballot, first: Ballot = _NONE) -> str:
    """Return the lines on what a student has handed in: what to do, and after the run the verdict.

    Args:
        first: what the student handed in when it was asked for the first time, if it was asked again.
    """
    mine, before = ballot.choice, ""
    if first.choice is not None and not poll.verdicts:
        answer = element("b", "", inline_html(poll.choices[first.choice]))
        before = element("p", f"{tr('Your first answer:')} ", answer, class_="first")
    if poll.verdicts:
        line = _verdict_html(poll, ballot)
    elif mine is None:
        ask = tr("Your prediction? Answer here, or with the keys 1 to {count}.", count=len(poll.choices))
        if poll.round > 1:
            ask = tr("Asked again: talk it over with your neighbours, then answer once more.")
        line = element("p", ask if poll.open else tr("Answers are closed."), class_="mine duet-say")
    else:
        until = tr("You may change it until the reveal.") if poll.open else tr("Answers are closed.")
        answer = element("b", "", inline_html(poll.choices[mine]))
        line = element("p", f"{tr('Your prediction:')} ", answer, element("span", f". {until}"), class_="mine duet-say")
    return element("div", "", before, line, class_="duet duet-lesson")


def _verdict_html(poll: Poll, ballot: Ballot) -> str:
    mine, figure, near = ballot.choice, "", ""
    if poll.drawing is not None and ballot.curve:
        figure = element("figure", "", drawing_svg(poll.drawing, ballot.curve, poll.truth), class_="duet duet-curves")
        near = drawing_verdict_html(judge_drawing(poll.drawing, ballot.curve, poll.truth, spoken().language))
    verdict = poll.verdicts[mine] if mine is not None else None
    measured = [element("p", line) for line in poll.outcome]
    if verdict is None or mine is None:
        return figure + element("div", "", near, element("b", tr("Measured in this run")), *measured, class_="card duet-say")
    mark, kind = ("✓", "right") if verdict.right else ("↺", "wrong")
    answers = element(
        "dl",
        "",
        element("dt", tr("You said")),
        element("dd", "", inline_html(poll.choices[mine])),
        element("dt", tr("Measured")),
        element("dd", "", *measured),
    )
    head = element("p", "", element("span", mark), " ", element("b", verdict.headline), class_="mark")
    return figure + element("div", "", near, head, answers, lesson_html(verdict.reply), class_=f"card {kind} duet-say")
