"""Film of five seconds around the nearest moment of a push."""

import io
from typing import Final

import numpy as np
from matplotlib import font_manager
from PIL import Image, ImageDraw, ImageFont

from app.features.figures.render import Viewpoint, arms, furniture, render
from app.i18n.speaking import decimal
from app.session.replay import Replay, make_film
from app.stage.camera_view import contact_points, view_of
from app.theme import PALETTES, blend
from scenes.history import COLUMN
from scenes.inputs import Recorded
from scenes.wanted import while_wanted

SECONDS: Final = 5.0
RATE: Final = 10.0
"""Frames per second."""

BEFORE: Final = 3.0
"""Time before the nearest moment [s]."""

SIZE: Final = (360, 270)
"""Width and height [px]."""

_INK: Final = PALETTES["light"]


def film_bytes(recorded: Recorded, size: tuple[int, int] = SIZE, rate: float = RATE) -> bytes:
    """Animated WebP of a push of two arms; a short push ends with a still picture."""
    replay = Replay(make_film(recorded))
    nearest = replay.nearest_moment
    begin = max(
        replay.begin, min((replay.begin if nearest is None else nearest) - BEFORE, replay.end - SECONDS)
    )
    times = begin + np.arange(round(SECONDS * rate)) / rate
    steps = [replay.nearest(min(float(time), replay.end)) for time in times]
    # A still picture is drawn once.
    seen = list(dict.fromkeys(steps))
    frames = [_frame(replay, step, size) for step in while_wanted(seen)]
    lengths = [round(1000.0 / rate * steps.count(step)) for step in seen]
    out = io.BytesIO()
    frames[0].save(out, "WEBP", save_all=True, append_images=frames[1:], duration=lengths, loop=0, quality=82)
    return out.getvalue()


def _frame(replay: Replay, step: int, size: tuple[int, int]) -> Image.Image:
    replay.seek_step(step)
    simulation = replay.simulation
    colours = tuple("orange" if arm is simulation.guided else "silver" for arm in simulation.room.arms)
    drawn = [*furniture(simulation.room), *arms(simulation.room, simulation.positions, colours)]
    camera = view_of(simulation)
    picture = Image.fromarray(render(drawn, camera, *size, samples=1))
    row = simulation.history.table(1)[0]
    distance, critical = float(row[COLUMN["d"]]), simulation.settings.law.critical_distance
    simulation.kinematics.update(simulation.positions)
    ends = Viewpoint(camera, *size).project(contact_points(simulation))
    colour = blend(_INK.calm, _INK.activation, float(row[COLUMN["lambda"]]))
    draw = ImageDraw.Draw(picture)
    draw.line([(float(x), float(y)) for x, y in ends], fill=colour, width=max(2, size[1] // 80))
    font = ImageFont.truetype(font_manager.findfont("DejaVu Sans"), max(9, size[1] // 15))
    words = (
        f"d = {1000.0 * distance:.1f} mm".replace("-", "−")
        + f"    dₘ = {1000.0 * critical:.0f} mm    {replay.time:.1f} s"
    )
    draw.text(
        (size[1] // 30, size[1] // 40),
        decimal(words),
        fill=_INK.alarm_ink if distance < critical else _INK.ink,
        font=font,
    )
    return picture
