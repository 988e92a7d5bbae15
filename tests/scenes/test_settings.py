"""Settings: values from outside are accepted exactly, or refused with the valid values."""

import math
from dataclasses import fields, replace

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from controllers.errors import BadSetting
from scenes.setting_spec import SPEC, Spec, Tab
from scenes.settings import (
    ArmName,
    HardwareSettings,
    LawSettings,
    RunSettings,
    changed,
    specs,
    validate,
    values,
)

SPECS = specs()
DEFAULTS = values(RunSettings())
NUMBERS = [key for key, spec in SPECS.items() if spec.is_number and not isinstance(DEFAULTS[key], bool)]
TEXTS = [key for key, spec in SPECS.items() if spec.read is not None]
CHOICES = [key for key, spec in SPECS.items() if spec.choices]
FLAGS = [key for key in SPECS if isinstance(DEFAULTS[key], bool)]


def refused(key: str, value: object, *words: str) -> None:
    settings = RunSettings()
    with pytest.raises(BadSetting) as caught:
        changed(settings, key, value)
    text = str(caught.value)
    assert "\n" not in text and len(text) < 400
    for word in (key, *words):
        assert word in text
    assert settings == RunSettings() and values(settings) == DEFAULTS


def bounds(spec: Spec) -> tuple[str, str]:
    return f"{spec.low:g}", f"{spec.high:g}"


def test_a_choice_needs_one_label_per_value() -> None:
    """With a missing or extra label no control could be built."""
    for labels in ((), ("Left",), ("Left", "Right", "Both")):
        with pytest.raises(ValueError, match="argument"):
            Tab("Arms").choice("left", ArmName, "guided", "your arm", "The arm that you move.", *labels)
    assert Tab("Arms").choice("left", ArmName, "k", "l", "?", "Left", "Right").metadata[SPEC].options() == {
        "left": "Left",
        "right": "Right",
    }


def test_declared_fields() -> None:
    assert len(SPECS) == len(fields(RunSettings)) - 2 + len(fields(LawSettings)) + len(
        fields(HardwareSettings)
    )
    assert list(SPECS) == list(DEFAULTS) and sorted(NUMBERS + CHOICES + FLAGS + TEXTS) == sorted(SPECS)
    for key, spec in SPECS.items():
        assert spec.key == key and spec.help and 0 < len(spec.label) <= 11
    assert validate(RunSettings()) == RunSettings()
    for key in NUMBERS:
        assert math.isfinite(SPECS[key].low) and math.isfinite(SPECS[key].high)
        assert SPECS[key].low <= DEFAULTS[key] <= SPECS[key].high and SPECS[key].step > 0.0
    for key in CHOICES:
        assert DEFAULTS[key] in SPECS[key].choices
    # All choices, and their defaults.
    expected = {
        "scene": "solo ball hold master_slave imitation first_task", "rig": "torso table", "guided": "left right",
            "robot": "lwr panda ur5 lwr_panda lwr_ur5 panda_lwr panda_ur5 ur5_lwr ur5_panda",
        "task": "position pose", "avoid": "paper free guided both", "following": "identical mirrored", "path": "stay circle",
        "point": "hand elbow arm", "ball": "still cross", "clip": "medley wave clap cross reach", "pairs": "single soft smooth",
        "first": "wall stops singular tip all", "together": "ratios stages",
        "start": "usual between", "bounds": "distance scale null_space",
        "law": "smooth_priority strict_priority strict_switched null_space_avoidance potential_field barrier_qp intermediate_value"
        " task_activation continuous_inverse hierarchical_inverse lexicographic_qp set_based_task drawn_curve lever unprotected",
    }  # fmt: skip
    assert {key: " ".join(SPECS[key].choices) for key in CHOICES} == expected
    first = {key: SPECS[key].choices[0] for key in CHOICES}
    first |= {"scene": "hold", "guided": "right", "following": "mirrored", "pairs": "smooth"}
    assert {key: DEFAULTS[key] for key in CHOICES} == first
    assert not any(DEFAULTS[key] for key in FLAGS)
    # g dt ≤ 1 and K dt < 1 for the largest values: no setting moves joints past their stops.
    assert SPECS["g"].high * SPECS["dt"].high <= 1.0 and SPECS["k"].high * SPECS["dt"].high < 1.0


def test_the_promised_defaults_and_ranges() -> None:
    promised = {"dm": (0.15, 0.03, 0.30), "n": (6.0, 1.0, 20.0), "v": (0.30, 0.0, 1.0), "k": (2.0, 0.0, 20.0)}
    promised |= {"dt": (0.005, 0.00125, 0.020)}
    assert {key: (DEFAULTS[key], SPECS[key].low, SPECS[key].high) for key in promised} == promised
    assert {key: DEFAULTS[key] for key in ("wmax", "beta", "g")} == {"wmax": 0.25, "beta": 100.0, "g": 10.0}


def taken(key: str, value: object, expected: object) -> None:
    settings = changed(RunSettings(), key, value)
    assert values(settings) == DEFAULTS | {key: expected}
    assert type(values(settings)[key]) is type(DEFAULTS[key]) and validate(settings) == settings


@given(st.sampled_from(NUMBERS), st.floats(0.0, 1.0))
def test_numbers_in_range_are_accepted_to_the_bit_also_as_text(key: str, part: float) -> None:
    spec = SPECS[key]
    value: float = min(max(spec.low + part * (spec.high - spec.low), spec.low), spec.high)
    if isinstance(DEFAULTS[key], int):
        value = round(value)
    taken(key, value, value)
    taken(key, str(value), value)


def test_choices_and_flags_are_accepted_in_the_usual_spellings() -> None:
    for key in CHOICES:
        for choice in SPECS[key].choices:
            taken(key, choice, choice)
    for key in FLAGS:
        for on in (True, "1", "True", "YES"):
            taken(key, on, True)
        for off in (False, "off", "no"):
            taken(key, off, False)


@pytest.mark.parametrize("key", NUMBERS)
def test_range_ends_survive_the_conversion_to_the_page_s_unit(key: str) -> None:
    spec = SPECS[key]
    for end in (spec.low, spec.high):
        back = end * spec.page_scale / spec.page_scale
        for value in (back, math.nextafter(back, math.inf), math.nextafter(back, -math.inf)):
            if isinstance(DEFAULTS[key], int):
                value = round(value)
            assert values(changed(RunSettings(), key, value))[key] == pytest.approx(end, abs=1e-9)
            assert spec.low <= values(changed(RunSettings(), key, value))[key] <= spec.high


def test_validate_finds_bad_values_in_a_whole_tree() -> None:
    good = RunSettings()
    for key, bad in (
        ("dt", replace(good, dt=math.inf)),
        ("n", replace(good, law=replace(good.law, order=math.nan))),
    ):
        with pytest.raises(BadSetting, match=key):
            validate(bad)


@given(st.sampled_from(NUMBERS), st.floats(1e-6, 1e300), st.booleans())
def test_out_of_range_is_refused_with_the_range(key: str, beyond: float, above: bool) -> None:
    spec = SPECS[key]
    slack = 1e-9 * max(1.0, abs(spec.low), abs(spec.high))
    value = spec.high + beyond if above else spec.low - beyond
    assume(value > spec.high + 2.0 * slack or value < spec.low - 2.0 * slack)
    refused(key, value, *bounds(spec), spec.unit)
    refused(key, repr(value), *bounds(spec), spec.unit)


NOT_FINITE = (math.nan, math.inf, -math.inf, "nan", "inf", "-Infinity", "1e999", 10**400)
NOT_NUMBERS = (None, True, False, [], {}, (1.0,), b"1", 1j, object())
NOT_NUMBERS += ("", " ", "fast", "0.1 m", "0,15", "1;2", "\x00", "é" * 5000)


@pytest.mark.parametrize("key", TEXTS)
def test_a_text_is_normalised_or_refused(key: str) -> None:
    spec, default = SPECS[key], DEFAULTS[key]
    assert spec.read is not None and spec.read(default) == default
    assert values(changed(RunSettings(), key, " 0.1 : 1.000 , 0.2:0 "))[key] == "0.1:1,0.2:0"
    for value in (*NOT_FINITE, *NOT_NUMBERS):
        refused(key, value, "0.15:1")


@pytest.mark.parametrize("key", NUMBERS)
def test_a_value_that_is_not_a_finite_number_is_refused_with_the_range(key: str) -> None:
    for value in (*NOT_FINITE, *NOT_NUMBERS):
        refused(key, value, *bounds(SPECS[key]))


def test_a_seed_is_a_whole_number() -> None:
    for value in (1.5, "2.5", 1e-3):
        refused("seed", value, "whole number")
    assert changed(RunSettings(), "seed", 2.0).seed == 2


ANYTHING = st.text(max_size=60) | st.none() | st.integers() | st.floats()


@given(st.sampled_from(CHOICES), ANYTHING | st.booleans(), st.sampled_from(FLAGS), ANYTHING)
def test_an_invalid_choice_or_flag_is_refused_with_the_valid_values(
    key: str, choice: object, flag: str, on: object
) -> None:
    if choice not in SPECS[key].choices:
        refused(key, choice, *SPECS[key].choices)
    if not (isinstance(on, str) and on.lower() in {"1", "true", "on", "yes", "0", "false", "off", "no"}):
        refused(flag, on, "give 1 or 0")


@given(st.text(max_size=40))
def test_an_unknown_key_is_refused_with_the_command_that_lists_all(key: str) -> None:
    assume(key not in SPECS)
    with pytest.raises(BadSetting) as caught:
        changed(RunSettings(), key, 1.0)
    message = str(caught.value)
    assert repr(key) in message and "lwr-duet serve --help-all" in message and len(message) < 400
