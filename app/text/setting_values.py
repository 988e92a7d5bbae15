"""Values of settings as the page shows them."""

from app.i18n.catalogue import words_of
from app.i18n.speaking import spoken
from app.settings import Language, Settings
from controllers.errors import LazyText, NumberText
from scenes.setting_spec import Spec
from scenes.settings import specs


def value_text(key: str, value: object) -> str:
    spec: Spec = specs(Settings)[key]
    if spec.choices:
        return LazyText(spec.options()[str(value)])
    if isinstance(value, bool):
        return LazyText("on") if value else LazyText("off")
    if isinstance(value, (int, float)):
        return NumberText(f"{value * spec.page_scale:.6g} {spec.page_unit}".rstrip())
    return str(value)


def page_value(key: str, value: object, language: Language | None = None) -> str:
    text, words = value_text(key, value), spoken() if language is None else words_of(language)
    return words(text) if isinstance(text, LazyText | NumberText) else text
