"""HTML of a class."""

from typing import Final

from markupsafe import Markup

from app.features.classroom.ballots import VoterCount
from app.features.classroom.breakout_places import group_size
from app.features.classroom.classroom import Classroom, Poll
from app.features.classroom.tally_html import cloud_html, drawn_too, switches_text, tie_text
from app.features.lessons.curve_drawing import drawing_svg, judge_drawing, median_curve
from app.features.lessons.tally import Ballot
from app.i18n.speaking import spoken, tr
from app.page.panels.server_load import load_pills
from app.plots.curve_chart import Curve
from app.text.templates import macros

_NONE: Final = Ballot()


def poll_html(poll: Poll, live: bool = False) -> Markup:
    """Histogram and curves of the answers, with the measured result once known.

    `live`: for the teacher, before the reveal.
    """
    tally = poll.tally
    count = tr("{count} answered", count=tally.handed_in) + drawn_too(tally)
    if live:
        count += " · " + tr("{count} not yet", count=tally.waiting)
    rounds = ([] if poll.first is None else [(1, poll.first)]) + [(poll.round, tally)]
    words = _tie(poll), switches_text(poll.switches, poll.right)
    cloud = cloud_html(poll.drawing, rounds, poll.truth, poll.unseen)
    return macros("features/classroom/poll.html").poll(poll, count, rounds, words, cloud, live)


def voters_html(voters: VoterCount) -> Markup:
    """Empty before the first vote."""
    if not voters.votes:
        return Markup()
    pills = [
        ("", tr("votes: {count}", count=voters.votes)),
        ("", tr("addresses: {count}", count=voters.addresses)),
    ]
    if voters.pageless:
        pills.append(("halt", tr("votes without a page: {count}", count=voters.pageless)))
    return macros("page/panels/pills.html").in_class([pills])


def _tie(poll: Poll) -> str:
    text = tie_text(poll.tally)
    if not text or not poll.revealed or not poll.staged or not poll.runs:
        return text
    staged, *others = poll.staged
    if others:
        return f"{text} {tr('The run is compared with each of them.')}"
    return f"{text} {tr('The run is compared with answer {number}.', number=staged + 1)}"


def tied_html(poll: Poll) -> Markup:
    """Verdicts on tied answers; "" without a tie."""
    if len(poll.staged) < 2:
        return Markup()
    verdicts = [
        (i, verdict) for i in poll.staged if poll.verdicts and (verdict := poll.verdicts[i]) is not None
    ]
    return macros("features/classroom/poll.html").tied(
        poll, _near(poll, median_curve(poll.tally.curves)), verdicts
    )


def _near(poll: Poll, curve: Curve) -> Markup:
    if poll.drawing is None or not curve:
        return Markup()
    return macros("features/lessons/panel/lesson.html").drawn(
        judge_drawing(poll.drawing, curve, poll.truth, spoken().language)
    )


def heads_html(classroom: Classroom, expected: int = 0) -> Markup:
    """Students (0 `expected`: unknown), their activity, and the server's load."""
    present, exploring = classroom.heads
    students, places = max(present, expected), classroom.places.most
    pills = [("", tr("students here: {count}", count=present))]
    if classroom.free:
        pills.append(("go", tr("exploring: {count}", count=exploring)))
        if classroom.waiting:
            pills.append(("halt", tr("without a place: {count}", count=classroom.waiting)))
    elif present:
        pills.append(("go", tr("all follow")))
    if (size := group_size(students, places)) > 1:
        said = tr(
            "{students} students, room for {places}: groups of {size}",
            students=students,
            places=places,
            size=size,
        )
        pills.append(("halt", said))
    if classroom.work.hand_ins:
        pills.append(("go", tr("reports handed in: {count}", count=len(classroom.work.hand_ins))))
    if classroom.paused:
        pills.append(("halt", tr("everybody is paused")))
    rows = [pills] if classroom.load is None else [pills, load_pills(classroom.load)]
    return macros("page/panels/pills.html").in_class(rows, live=True)


def mine_html(poll: Poll, ballot: Ballot, first: Ballot = _NONE, keys: bool = True) -> Markup:
    """Lines on a student's ballot: instructions, and after the run the verdict.

    `first`: ballot of the first round; `keys`: the reader has a keyboard.
    """
    curves, near = Markup(), Markup()
    if poll.verdicts and poll.drawing is not None and ballot.curve:
        curves, near = drawing_svg(poll.drawing, ballot.curve, poll.truth), _near(poll, ballot.curve)
    return macros("features/classroom/poll.html").mine(poll, ballot, first, keys, curves, near)
