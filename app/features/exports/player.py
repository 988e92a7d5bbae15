"""One HTML file that plays a recorded run offline. viser's page (Apache 2.0) in it draws the scene."""

import base64
import gzip
import html
import json
import re
import struct
from pathlib import Path
from typing import Any, Final

import numpy as np
from markupsafe import Markup

from app.features.exports.recorded_curves import Curves, Panel
from app.features.exports.scene_film import PLACE, RATE, TURN, Filmed, film_scene
from app.i18n.speaking import decimal, spoken, tr
from app.recording.run_file import made_here, made_with
from app.settings import PageSettings
from app.stage.contact_view import contact_assets
from app.text.first_task_texts import in_symbols, least_name
from app.text.setting_values import page_value
from app.text.templates import macros
from app.web.pages import PageAssets, software_rendering, translation
from app.web.viser_internals import VISER_VERSION, client_html
from controllers.kinematics import Array
from scenes.history import COLUMN
from scenes.inputs import Recorded
from scenes.law_answers import LawAnswers
from scenes.rerun import newest_steps, rerun
from scenes.settings import RunSettings

LOCKED: Final = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval' 'wasm-unsafe-eval' blob: data:; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:; connect-src data: blob:; worker-src blob: data:"
)
"""Content policy: only what is in the file."""

SPEEDS: Final = ("0.25", "0.5", "1", "2", "4")

_HERE: Final = Path(__file__).parent


def player_html(recorded: Recorded, seconds: float, page: PageSettings) -> bytes:
    """File in the current language. `seconds`: played time at the end [s]; inf for all.

    Raises:
        BadSetting: the run is not possible here.
    """
    table = rerun(recorded).table[-newest_steps(recorded, seconds) :]
    panels = Curves(recorded, table, page.theme).panels(page.details)
    filmed, mark = film_scene(recorded, seconds, page), nearest_moment(table)
    return assembled(
        filmed, panels, recorded.stretches[-1].settings, page.theme == "dark", recorded.law, mark
    ).encode()


def nearest_moment(table: Array) -> float | None:
    """Time of the smallest d [s]; None without an obstacle."""
    d = table[:, COLUMN["d"]]
    return float(table[d.argmin(), COLUMN["t"]]) if np.isfinite(d).all() else None


def assembled(
    filmed: Filmed,
    panels: tuple[Panel, ...],
    run: RunSettings,
    dark: bool,
    own: LawAnswers | None = None,
    mark: float | None = None,
) -> str:
    """The finished page.

    `own`: custom law, or None; `mark`: moment at which the page opens [s]; None for the beginning.
    """
    client = client_html()
    scene = base64.b64encode(filmed.scene).decode()
    film = base64.b64encode(packed_film(filmed, panels, mark, least_name(run.quantity))).decode()
    title, law = page_value("scene", run.scene), page_value("law", run.law.law).replace("d_m", "dₘ")
    numbers = f"K = {decimal(f'{run.gain:g}')}/s; Duet {made_here()['duet']}"
    if own is None:
        v = decimal(f"{run.law.nominal_velocity:g}")
        of_law = f"dₘ = {decimal(f'{1000.0 * run.law.critical_distance:g}')} mm, n = {decimal(f'{run.law.order:g}')}, v = {v} m/s"
        numbers = f"{in_symbols(f'{law}; {of_law}', run.quantity)}, {numbers}"
    else:
        numbers = f"{tr(made_with(own.file, own.sha256))} {numbers}"
    assets = translation() + software_rendering() + contact_assets()
    assets += PageAssets((_HERE / "embedded_scene.js",), constants={"scene": scene, "dark": dark})
    made = macros("features/exports/player.html")
    head = made.head(Markup(LOCKED), VISER_VERSION, assets)
    body = made.body(
        title, numbers, SPEEDS, film, PageAssets((_HERE / "player.js",), (_HERE / "player.css",))
    )
    client = re.sub(
        r"<title>.*?</title>", lambda _: f"<title>Duet: {html.escape(title)}</title>", client, count=1
    )
    spoken_here = spoken().language
    lang = "en" if spoken_here == "pseudo" else spoken_here
    client = client.replace('<html lang="en">', f'<html lang="{lang}" data-words="{spoken_here}">', 1)
    client = client.replace('<meta charset="utf-8" />', f'<meta charset="utf-8" />{head}', 1)
    place = client.rindex("</body>")
    return f"{client[:place]}{body}{client[place:]}"


def packed_film(
    filmed: Filmed, panels: tuple[Panel, ...], mark: float | None = None, marked: str = ""
) -> bytes:
    """Compressed: 4 bytes of length, JSON, and numbers from the next multiple of 8 bytes."""
    blob = bytearray()

    def numbers(values: Any, kind: str) -> dict[str, Any]:
        array = np.ascontiguousarray(values, f"<{kind}").ravel()
        blob.extend(bytes(-len(blob) % 8))
        at = len(blob)
        blob.extend(array.tobytes())
        return {"kind": kind, "at": at, "count": array.size}

    tracks: list[dict[str, Any]] = []
    for track in filmed.tracks:
        gaps = np.diff([0, *track.frames]).tolist()
        entry: dict[str, Any] = {"node": track.node, "what": track.what, "frames": gaps, "numbers": None}
        kind = _kind(track.what, track.values)
        if kind:
            values = np.array(track.values)
            entry["width"] = values[0].size
            entry["numbers"] = numbers(np.round(values * 32767.0) if kind == "i2" else values, kind)
        else:
            entry["values"] = [v.tolist() if isinstance(v, np.ndarray) else v for v in track.values]
        tracks.append(entry)
    drawn = [
        {
            **vars(panel),
            "times": numbers(panel.times, "f4"),
            "strokes": [
                {
                    **vars(s),
                    "name": [part for part in _parts(s.name) if part[0]],
                    "values": numbers(s.values, "f4"),
                }
                for s in panel.strokes
            ],
        }
        for panel in panels
    ]
    about = {
        "begin": filmed.times[0],
        "rate": RATE,
        "frames": len(filmed.times),
        "bodies": filmed.bodies,
        "mark": None if mark is None else {"time": mark, "name": f"{tr(marked)}, {decimal(f'{mark:.1f}')} s"},
        "words": {
            "play": tr("Play"),
            "pause": tr("Pause"),
            "of": tr("{time} of {end} s"),
            "point": decimal("."),
        },
        "tracks": tracks,
        "panels": drawn,
    }
    text = json.dumps(about, ensure_ascii=False, allow_nan=False).encode()
    head = struct.pack("<I", len(text)) + text
    return gzip.compress(head + bytes(-len(head) % 8) + bytes(blob), mtime=0)


def _kind(what: str, values: list[Any]) -> str:
    """Format of a track's values; "" for JSON."""
    first = values[0]
    if not isinstance(first, np.ndarray) or any(v.shape != first.shape for v in values):
        return ""
    if what == TURN:
        return "i2"
    if what == PLACE or first.dtype == np.float32:
        return "f4"
    return "u1" if first.dtype == np.uint8 else ""


def _parts(name: str) -> list[tuple[str, bool]]:
    """Pieces of a name; True for subscripts."""
    return [(html.unescape(piece), i % 2 == 1) for i, piece in enumerate(re.split(r"<sub>(.*?)</sub>", name))]
