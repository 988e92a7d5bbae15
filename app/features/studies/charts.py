"""Charts of the studies."""

from itertools import chain
from typing import Any, Final

from markupsafe import Markup

from app.features.studies.background_studies import BackgroundParts, BackgroundStudies, magnified
from app.features.studies.microscope_chart import microscope_html
from app.features.studies.trade_off_charts import map_html, safety_html
from app.i18n.speaking import N_, tr
from app.plots.chart_list import Charts, FurtherChart
from app.session.frame import Frame
from app.text.templates import element


def _tip(text: str) -> Markup:
    return element("div", text, class_="duet duet-tip")


def trade_off(frame: Frame, height: int) -> Markup:
    part = frame.part(BackgroundStudies)
    if part is None or part.trade_off is None:
        return _tip(tr("The trade-off map is not available for a custom law."))
    points = tuple(chain.from_iterable(part.trade_off.results(frame.settings.run).values()))
    return map_html(points, part.trade_off.size, frame.settings.run, height)


def safety(frame: Frame, height: int) -> Markup:
    part = frame.part(BackgroundStudies)
    if part is None or part.safety_curves is None:
        return _tip(tr("Laws are not compared while a custom law runs."))
    return safety_html(
        part.safety_curves.results(frame.settings.run), part.safety_curves.size, frame.settings.run, height
    )


def single_steps(frame: Frame, height: int) -> Markup:
    seen = magnified(frame)
    return (
        _tip(tr("Single steps are shown of the live run."))
        if seen is None
        else microscope_html(seen, frame.settings.run, height)
    )


def _size(parts: BackgroundParts[Any, Any] | None) -> float:
    return 0.0 if parts is None else parts.size


def _trade_off_size(frame: Frame) -> float:
    part = frame.part(BackgroundStudies)
    return _size(None if part is None else part.trade_off)


def _safety_size(frame: Frame) -> float:
    part = frame.part(BackgroundStudies)
    return _size(None if part is None else part.safety_curves)


CHARTS: Final[Charts] = {
    "map": FurtherChart(N_("trade-off of n and v"), trade_off, _trade_off_size),
    "safety": FurtherChart(N_("laws at equal safety"), safety, _safety_size),
    # Drawn at every refresh: its own buttons and new finer steps change it, too.
    "microscope": FurtherChart(N_("single steps at dt and dt/2"), single_steps, lambda frame: object()),
}
