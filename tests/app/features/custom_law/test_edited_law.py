"""A law edited on the page: only by the server's owner, saved whole, never over another editor's text."""

import json
import re
from pathlib import Path
from typing import Any

import pytest
import websockets

from app.features.custom_law.edited_file import (
    MOST,
    ChangedMeanwhile,
    Version,
    first_text,
    read_version,
    save_text,
)
from app.features.custom_law.student_law import student_law
from app.start import App
from app.web.origin_policy import PROOF
from controllers.errors import BadInputFile
from tests.app.conftest import Arrive, Join, OpenHouse, live_sessions
from tests.app.features.custom_law.helpers import edited
from tests.app.page.helpers import Client, hotkey_uuid, shown
from tests.blocking_client import BlockingClient

LAW = "def law(situation):\n    return situation.nominal\n"
PLACE = "Your law: my_law.py"
"""Heading of the editor of a law file; visitors have one of a formula, which is not a program."""

STATE = re.compile(r'duet-law-state" data-text="(\{.*\})"></i>')


def test_a_file_is_saved_whole_and_only_over_the_version_that_was_read(file: Path) -> None:
    assert read_version(file) == Version(first_text(file), "")
    mine = save_text(file, LAW, "")
    assert read_version(file) == mine == Version(LAW, mine.sha256)
    file.write_text("x = 1\n", encoding="utf-8")
    with pytest.raises(ChangedMeanwhile) as found:
        save_text(file, LAW + "# more\n", mine.sha256)
    assert found.value.version == read_version(file) and file.read_text(encoding="utf-8") == "x = 1\n"
    assert save_text(file, LAW, found.value.version.sha256) == mine == save_text(file, LAW, "")
    assert [path.name for path in file.parent.iterdir()] == [file.name]
    file.write_bytes(b"x = 1\r\n")
    assert save_text(file, "x = 2\n", read_version(file).sha256) == read_version(file)
    assert file.read_bytes() == b"x = 2\r\n"


def test_invalid_text_is_not_written_and_uneditable_files_are_named(file: Path) -> None:
    version = save_text(file, LAW, "")
    for text, said in (("a\0b", "zero byte"), ("é" * (MOST // 2 + 1), "48 kB")):
        with pytest.raises(BadInputFile, match=said):
            save_text(file, text, version.sha256)
        assert read_version(file) == version
    file.write_bytes(b"\xff\xfe law")
    with pytest.raises(BadInputFile, match="not UTF-8"):
        save_text(file, LAW, "")
    assert file.read_bytes() == b"\xff\xfe law"
    with pytest.raises(BadInputFile, match="cannot be written"):
        save_text(file.parent / "missing" / "my_law.py", LAW, "")


def state_of(visitor: Client) -> dict[str, Any] | None:
    """State that the page's script gets; None without an editor."""
    found = STATE.search(shown(visitor))
    return None if found is None else json.loads(found[1])


def enter(visitor: BlockingClient, box: str, text: str, number: int = 1, base: str = "") -> None:
    visitor.send({"type": "GuiUpdateMessage", "uuid": box, "updates": {"value": f"{number} {base}\n{text}"}})


def test_the_owner_saves_and_runs_and_reads_every_refusal(
    house: OpenHouse, arrive: Arrive, file: Path
) -> None:
    owner = arrive(house(features=(edited(file),)))
    owner.visitor.wait_for(state_of)
    box = (state_of(owner.visitor) or {})["box"]
    texts = (LAW, "def law(situation):\n    return 1 +\n", "a\0b", "x" * MOST + "y", LAW + "# 2\n", "")
    said = ("saved", "saved", "refused", "refused", "conflict", "conflict")
    base = ""
    for number, (text, answer) in enumerate(zip(texts, said, strict=True), 1):
        enter(owner.visitor, box, text, number, base)
        owner.visitor.wait_for(lambda v, number=number: (state_of(v) or {})["number"] == str(number))
        state = state_of(owner.visitor) or {}
        assert state["said"] == answer and bool(state["refused"]) == (answer == "refused")
        if number == 2:
            owner.visitor.wait_for(lambda v: (state_of(v) or {})["line"] == 2)
            base = "of another version"
        elif number == 1:
            base = state["sha"]
            assert owner.session.law.of_run is not None and owner.session.ghost is not None
    assert file.read_text(encoding="utf-8") == texts[1]
    # Values that the script never sends, and one that the gate refuses.
    for forged in ("", "\n", "1", "x" * 200_000, 1.0):
        owner.visitor.send({"type": "GuiUpdateMessage", "uuid": box, "updates": {"value": forged}})
    owner.visitor.wait_for(lambda v: v.closed is not None)
    assert file.read_text(encoding="utf-8") == texts[1]


PROXIES = (
    {"X-Forwarded-For": "203.0.113.5"},
    {"Forwarded": "for=203.0.113.5"},
    {"X-Real-IP": "::1"},
    {"Via": "1.1 proxy"},
)


def test_a_visitor_gets_no_editor_and_cannot_forge_a_save(
    house: OpenHouse, arrive: Arrive, join: Join, file: Path
) -> None:
    opened: App = house(features=(edited(file),), sessions=12)
    owner = arrive(opened)
    owner.visitor.wait_for(state_of)
    box = (state_of(owner.visitor) or {})["box"]
    assert PLACE in str(list(owner.visitor.mirror.gui.values()))
    visitors = [join(opened, headers=headers) for headers in PROXIES]
    visitors.append(join(opened, headers={PROOF: "forged", "X-Forwarded-Context": "/user/ann/"}))
    for visitor in visitors:
        visitor.wait_for(lambda v: len(v.mirror.commands) >= 14)
        assert PLACE not in str(list(visitor.mirror.gui.values()))
        enter(visitor, box, LAW)
        visitor.send({"type": "CommandTriggerMessage", "uuid": hotkey_uuid(visitor, "pause")})
    with pytest.raises(websockets.InvalidStatus, match="403"):
        BlockingClient(opened.url, "https://evil.example")
    others = [one for one in live_sessions(opened).values() if one is not owner.session]
    assert len(others) == len(visitors)
    # A connection's messages are handled in order: the forged entries have been handled.
    owner.visitor.wait_for(lambda _: all(one.paused for one in others))
    assert not file.exists() and (state_of(owner.visitor) or {})["number"] == ""
    enter(owner.visitor, box, LAW)
    owner.visitor.wait_for(lambda v: (state_of(v) or {})["said"] == "saved")
    assert not any(one.law.given for one in others) and student_law(owner.session).path == file


@pytest.mark.parametrize(
    "options",
    [
        {"allowed_origins": ("https://duet.example.org",)},
        {"embed_origins": ("https://moodle.example.org",)},
        {"proof": "secret"},
        {"host": "0.0.0.0"},
    ],
)
def test_a_server_open_to_others_has_no_editor(
    house: OpenHouse, join: Join, file: Path, options: dict[str, Any]
) -> None:
    opened = house(features=(edited(file),), **options)
    visitor = join(opened)
    visitor.wait_for(lambda v: len(v.mirror.commands) >= 14)
    assert PLACE not in str(list(visitor.mirror.gui.values()))
    if "proof" in options:
        join(opened, headers={PROOF: "secret", "X-Forwarded-For": "203.0.113.5"}).wait_for(state_of)
