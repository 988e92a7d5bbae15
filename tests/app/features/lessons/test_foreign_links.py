"""Lesson cases of the core's `test_foreign_links.py`."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.features.lessons.panel.lesson_visit import lesson_link
from app.features.lessons.panel.welcome import is_for_newcomers
from app.hosting.visitor_record import link_of
from app.i18n.reader_language import language_asked, look_of
from app.settings import Settings, from_query
from app.web.pages import page_query

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
def test_parameters_appended_by_others_are_ignored_silently(key: str) -> None:
    assert from_query({"rig": "table", key: "x"}, Settings()) == from_query({"rig": "table"}, Settings())
    assert is_for_newcomers({key: "x"}) and not is_for_newcomers({key: "x", "rig": "table"})


@given(
    st.sampled_from(LINKS),
    st.lists(st.sampled_from(APPENDED), max_size=6),
    st.integers(0, 10**6),
    st.booleans(),
    st.booleans(),
)
def test_a_link_works_the_same_with_appended_parameters(
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
