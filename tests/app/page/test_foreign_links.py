"""Links with appended foreign parameters, with &amp;, and with unknown names."""

from collections.abc import Mapping

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.i18n.catalogue import words_of
from app.settings import (
    FOREIGN_KEYS,
    LANGUAGES,
    LOOKS,
    Settings,
    from_query,
    is_appended,
    is_foreign,
    to_query,
)
from controllers.errors import BadSetting
from scenes.setting_spec import add_choice, nearest_names
from scenes.settings import RunSettings, changed, specs


def test_no_own_key_is_taken_for_a_foreign_one() -> None:
    ours = {*specs(Settings), *FOREIGN_KEYS, "screen", "origin", "initialCameraPosition"}
    assert [key for key in ours if is_appended(key)] == []
    assert [key for key in specs(Settings) if is_foreign(key)] == []
    assert not is_foreign("dmm")


def test_escaped_keys_of_settings_are_repaired() -> None:
    settings, problems = from_query({"rig": "table", "amp;dm": "0.1", "AMP;amp;n": "3"}, Settings())
    assert (settings.run.rig, settings.run.law.critical_distance, settings.run.law.order, problems) == (
        "table",
        0.1,
        3.0,
        (),
    )
    for key in LOOKS:
        (value,) = to_query(
            changed(
                Settings(),
                key,
                {"theme": "dark", "profile": "projector", "picture": "fast", "lang": "de"}[key],
            ),
            Settings(),
        ).keys() - {"whole"}
        assert value == key


NEAREST: Mapping[str, str] = {
    "dmm": "dm", "DM": "dm", "d_m": "dm", "laws": "law", "pair": "pairs", "language": "lang", "scenes": "scene", "lessons": "lesson",
    "steps": "step", "embedded": "embed", "robots": "robot", "seeds": "seed", "themes": "theme",
}  # fmt: skip


@pytest.mark.parametrize("key", NEAREST)
def test_an_unknown_name_gets_the_nearest_names_as_suggestions(key: str) -> None:
    settings, (problem,) = from_query({key: "1"}, Settings())
    assert settings == Settings()
    suggested = problem.split("did you mean ")[1].split("?")[0].split(", ")
    assert NEAREST[key] in suggested and len(suggested) <= 3 and "lwr-duet serve --help-all" in problem


@given(st.text(min_size=1, max_size=60))
def test_no_message_about_a_name_lists_all_names(key: str) -> None:
    names = {*specs(Settings)}
    _, problems = from_query({key: "🦆"}, Settings())
    try:
        changed(RunSettings(), key, "🦆")
    except BadSetting as error:
        problems += (str(error),)
    for problem in problems:
        for said in (problem, *(words_of(language)(problem) for language in LANGUAGES)):
            assert (
                len(said) < 400 and len(names & {*said.replace(",", " ").replace("?", " ").split()}) <= 20
            ), said


@pytest.mark.usefixtures("registry")
def test_an_unknown_value_lists_only_some_choices() -> None:
    for i in range(8):
        add_choice("robot", f"arm{i}-0123456789ab", f"arm {i}")
    with pytest.raises(BadSetting) as caught:
        changed(RunSettings(), "robot", "pandas")
    message = str(caught.value)
    assert "choose from panda," in message and message.endswith("….") and message.count(",") <= 3
    assert nearest_names("🦆", ("lwr", "panda")) == ()
