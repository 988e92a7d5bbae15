"""The picture in one sentence."""

from typing import Final

import viser

from app.i18n.speaking import decimal, tr
from app.page.panels import PagePanel
from app.page.view import View
from app.session.action_handlers import ActionHandlers
from app.session.actions import Describe
from app.session.frame import Frame
from scenes.experiments import Experiment
from scenes.quantities import quantity_of_pair
from scenes.simulation import Simulation

SHOWN: Final = 20.0
"""Duration of the note [s]."""

NEITHER: Final = 0.005
"""λ below which 0.00 is written."""


class SceneWords(PagePanel):
    """Sentence over the picture, also for screen readers."""

    def __init__(self, client: viser.ClientHandle, view: View, handlers: ActionHandlers) -> None:
        self._client, self._view = client, view
        self._asked = False
        self._note: viser.NotificationHandle | None = None
        self._experiment: Experiment | None = None
        handlers.add(Describe, self._describe)

    def _describe(self, action: Describe) -> None:
        del action
        self._asked = True

    def show(self, frame: Frame) -> None:
        experiment = frame.settings.run.experiment
        if self._note is not None and (self._asked or experiment is not self._experiment):
            # It describes another moment, or another experiment.
            self._note.remove()
            self._note = None
        self._experiment = experiment
        if not self._asked:
            return
        self._asked = False
        asking = self._view.keeps_back()
        self._note = self._client.add_notification(
            tr("In the picture"), scene_sentence(frame, asking), color="gray", auto_close_seconds=SHOWN
        )


def scene_sentence(frame: Frame, asking: bool = False) -> str:
    """Positions of the hands and, with an obstacle, d, λ and the arm that gives way; no λ while `asking`."""
    simulation, sample = frame.simulation, frame.sample
    parts = [_place_of_hand(simulation, number) for number in range(len(simulation.room.arms))]
    if sample.pair >= 0:
        kept = quantity_of_pair(simulation.settings.quantity, sample.pair)
        parts.append(f"{kept.symbol} = {1e3 * sample.distance:.0f} {kept.page_unit}".replace("-", "−"))
    said = "; ".join(parts)
    if sample.pair < 0 or asking:
        return f"{said}."
    return (
        f"{said}; λ = {decimal(f'{sample.activation:.2f}')}: {_who_gives_way(simulation, sample.activation)}."
    )


def _place_of_hand(simulation: Simulation, number: int) -> str:
    """Position from the room's origin, along its axes as seen in the first view."""
    hand = simulation.kinematics.hand_pose(simulation.room.arms[number]).translation
    x, y, z = (round(100.0 * length) for length in hand.tolist())
    towards = simulation.room.rig.camera.toward
    # Seen along −x, y is to the right; seen along y, x is.
    near, right = (x, y) if abs(towards[0]) > abs(towards[1]) else (-y, x)
    return tr(
        "{arm}: hand {across}, {depth}, {up}",
        arm=_arm_name(simulation, simulation.room.arms[number] is simulation.guided),
        across=tr("{n} cm to the right", n=right) if right >= 0 else tr("{n} cm to the left", n=-right),
        depth=tr("{n} cm towards you", n=near) if near >= 0 else tr("{n} cm away from you", n=-near),
        up=tr("{n} cm up", n=z),
    )


def _arm_name(simulation: Simulation, yours: bool) -> str:
    # With a ball, the visitor moves the ball.
    return tr("orange arm") if yours and simulation.room.ball is None else tr("silver arm")


def _who_gives_way(simulation: Simulation, activation: float) -> str:
    if activation < NEITHER:
        return tr("no arm gives way")
    if simulation.settings.both_avoid:
        return tr("both arms give way")
    own = simulation.settings.avoid == "guided" or simulation.avoiding is simulation.guided
    return tr("{arm} gives way", arm=_arm_name(simulation, own))
