"""The sentence that describes the picture agrees with the run."""

import re
from unittest.mock import MagicMock
from urllib.parse import parse_qsl

import pytest

from app.page.panels.scene_words import SceneWords, scene_sentence
from app.session.action_handlers import ActionHandlers
from app.session.actions import Describe
from app.session.frame import freeze
from app.session.session import Session
from app.settings import Settings, from_query


@pytest.mark.parametrize(
    ("query", "who"),
    [
        ("scene=hold&dm=0.05&n=20", "no arm gives way"),
        ("scene=hold&dm=0.3&n=1", "silver arm gives way"),
        ("scene=hold&dm=0.3&n=1&avoid=guided", "orange arm gives way"),
        ("scene=hold&dm=0.3&n=1&avoid=both", "both arms give way"),
        ("scene=ball&dm=0.3&n=1", "silver arm gives way"),
    ],
)
def test_the_sentence_names_hands_distance_and_avoiding_arms(query: str, who: str) -> None:
    session = Session(from_query(dict(parse_qsl(query)), Settings())[0])
    frame = freeze(session, 0.0)
    said = scene_sentence(frame)
    assert said.endswith(
        f"; d = {1e3 * frame.sample.distance:.0f} mm; λ = {frame.sample.activation:.2f}: {who}."
    )
    hands = re.findall(
        r"(orange|silver) arm: hand \d+ cm to the (?:left|right), \d+ cm (?:towards|away from) you, \d+ cm up",
        said,
    )
    assert sorted(hands) == (["silver"] if "ball" in query else ["orange", "silver"])
    assert scene_sentence(frame, asking=True) == said.partition("; λ")[0] + "."


def test_the_note_disappears_with_its_experiment() -> None:
    session, client, handlers = Session(Settings()), MagicMock(), ActionHandlers()
    words = SceneWords(client, MagicMock(), handlers)
    handlers.do(Describe())
    note = client.add_notification.return_value
    for change, gone in (("dm", 0.2), False), (("scene", "ball"), True):
        words.show(freeze(session, 0.0))
        session.change(*change)
        words.show(freeze(session, 0.0))
        assert note.remove.called == gone
    client.add_notification.assert_called_once()
