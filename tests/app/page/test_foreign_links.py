"""Links as they arrive: with what others have appended to them, with &amp;, and with names that no setting has."""

from collections.abc import Mapping

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.features.lessons.panel.lesson_visit import lesson_link
from app.features.lessons.panel.welcome import is_for_newcomers
from app.hosting.visitor_record import link_of
from app.i18n.catalogue import words_of
from app.i18n.reader_language import language_asked, look_of
from app.settings import FOREIGN_KEYS, LANGUAGES, LOOKS, Settings, from_query, is_appended, is_foreign, to_query
from app.web.pages import page_query
from controllers.errors import BadSetting
from scenes.setting_spec import add_choice, nearest_names
from scenes.settings import RunSettings, changed, specs

WORDS = """
    utm_source utm_medium utm_campaign utm_term utm_content utm_id fbclid gclid gclsrc dclid gbraid wbraid gad_source gad_campaignid
    msclkid yclid ysclid twclid ttclid li_fat_id rdt_cid mc_eid mc_cid igshid igsh mibextid ref ref_src ref_url _ga _gl _hsenc _hsmi
    __hstc __hssc hsCtaTracking hsa_cam mkt_tok vero_id vero_conv oly_anon_id oly_enc_id s_cid pk_campaign pk_kwd mtm_campaign
    matomo_campaign piwik_campaign fb_action_ids __tn__ __cft__[0] _openstat epik srsltid usp si feature spm trk trk_contact
    _branch_match_id
    _x_tr_sl _x_tr_tl _x_tr_hl forceview redirects UTM_SOURCE Fbclid
    """
APPENDED = WORDS.split()

LINKS = (
    "rig=table&dm=0.1&n=10",
    "lesson=3&step=2",
    "lesson=drift",
    "push=AAAA&lang=de",
    "attack=abc&whole=1",
    "embed=1&panel=all&lang=sl",
    "guest=abcdefgh",
    "key=secret&screen=1",
    "lang=de&theme=dark&profile=projector",
    "",
)


@pytest.mark.parametrize("key", APPENDED)
def test_what_others_append_is_ignored_without_a_word(key: str) -> None:
    assert from_query({"rig": "table", key: "x"}, Settings()) == from_query({"rig": "table"}, Settings())
    assert is_for_newcomers({key: "x"}) and not is_for_newcomers({key: "x", "rig": "table"})


def test_no_name_of_ours_is_taken_for_one_of_theirs() -> None:
    ours = {*specs(Settings), *FOREIGN_KEYS, "screen", "origin", "initialCameraPosition"}
    assert [key for key in ours if is_appended(key)] == []
    assert [key for key in specs(Settings) if is_foreign(key)] == []
    assert not is_foreign("dmm")


@given(
    st.sampled_from(LINKS), st.lists(st.sampled_from(APPENDED), max_size=6), st.integers(0, 10**6), st.booleans(), st.booleans()
)
def test_a_link_shows_the_same_with_what_others_append(
    link: str, appended: list[str], seed: int, escaped: bool, twice: bool
) -> None:
    parts = [part for part in link.split("&") if part]
    for i, key in enumerate(appended):
        parts.insert((seed >> i) % (len(parts) + 1), f"{key}=IwAR{i}")
    separator = "&amp;amp;" if escaped and twice else "&amp;" if escaped else "&"
    plain, found = page_query(f"/?{link}"), page_query(f"/?{separator.join(parts)}")
    assert found == plain
    assert from_query(found, Settings()) == from_query(plain, Settings())
    assert lesson_link(found) == lesson_link(plain) and link_of(found) == link_of(plain)
    assert is_for_newcomers(found) == is_for_newcomers(plain)
    assert look_of(found, "en", Settings()) == look_of(plain, "en", Settings())
    assert language_asked(found, "de") == language_asked(plain, "de")


def test_the_key_of_a_setting_is_mended_wherever_it_is_read() -> None:
    settings, problems = from_query({"rig": "table", "amp;dm": "0.1", "AMP;amp;n": "3"}, Settings())
    assert (settings.run.rig, settings.run.law.critical_distance, settings.run.law.order, problems) == ("table", 0.1, 3.0, ())
    for key in LOOKS:
        (value,) = to_query(
            changed(Settings(), key, {"theme": "dark", "profile": "projector", "picture": "fast", "lang": "de"}[key]), Settings()
        ).keys() - {"whole"}
        assert value == key


NEAREST: Mapping[str, str] = {
    "dmm": "dm", "DM": "dm", "d_m": "dm", "laws": "law", "pair": "pairs", "language": "lang", "scenes": "scene", "lessons": "lesson",
    "steps": "step", "embedded": "embed", "robots": "robot", "seeds": "seed", "themes": "theme",
}  # fmt: skip


@pytest.mark.parametrize("key", NEAREST)
def test_an_unknown_name_is_answered_with_the_nearest_ones(key: str) -> None:
    settings, (problem,) = from_query({key: "1"}, Settings())
    assert settings == Settings()
    suggested = problem.split("did you mean ")[1].split("?")[0].split(", ")
    assert NEAREST[key] in suggested and len(suggested) <= 3 and "lwr-duet serve --help" in problem


@given(st.text(min_size=1, max_size=60))
def test_no_message_about_a_name_lists_them_all(key: str) -> None:
    names = {*specs(Settings)}
    _, problems = from_query({key: "🦆"}, Settings())
    try:
        changed(RunSettings(), key, "🦆")
    except BadSetting as error:
        problems += (str(error),)
    for problem in problems:
        for said in (problem, *(words_of(language)(problem) for language in LANGUAGES)):
            assert len(said) < 400 and len(names & {*said.replace(",", " ").replace("?", " ").split()}) <= 20, said


@pytest.mark.usefixtures("registry")
def test_an_unknown_value_lists_no_more_than_some() -> None:
    for i in range(8):
        add_choice("robot", f"arm{i}-0123456789ab", f"arm {i}")
    with pytest.raises(BadSetting) as caught:
        changed(RunSettings(), "robot", "pandas")
    message = str(caught.value)
    assert "choose from panda," in message and message.endswith("….") and message.count(",") <= 3
    assert nearest_names("🦆", ("lwr", "panda")) == ()
