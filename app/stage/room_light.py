"""Background, light and floor: everything about the room's look that no simulation changes."""

import numpy as np
import viser

from app.settings import PageSettings
from app.theme import PALETTES, Palette


def light_room(scene: viser.SceneApi, page: PageSettings) -> None:
    """Set background, lights and floor for a theme and a kind of picture; may be called again for another."""
    palette, dark, fine = PALETTES[page.theme], page.theme == "dark", page.picture == "fine"
    top, bottom = (np.array(c, float) for c in palette.background)
    ramp = np.linspace(0.0, 1.0, 256)[:, None, None]
    scene.set_background_image(np.tile(top + (bottom - top) * ramp, (1, 8, 1)).round().astype(np.uint8), format="png")
    scene.configure_default_lights(enabled=False)
    scene.add_light_directional("/light/key", intensity=2.0, cast_shadow=fine, position=(2.4, -2.0, 4.0))
    scene.add_light_directional("/light/fill", intensity=0.7, position=(-2.5, 2.0, 2.0), color=(205, 222, 255), visible=fine)
    if fine:
        scene.configure_environment_map("studio", environment_intensity=0.42 if dark else 0.55)
    else:
        # Reflections are the dearest part of a picture drawn without a graphics card; plain light stands in for them.
        scene.configure_environment_map(None)
    scene.add_light_hemisphere(
        "/light/sky", sky_color=(255, 255, 255), ground_color=(150, 155, 165), intensity=2.2, visible=not fine
    )
    _lay_floor(scene, palette, fine)


def _lay_floor(scene: viser.SceneApi, palette: Palette, fine: bool) -> None:
    if fine:
        scene.add_grid(
            "/floor",
            width=6,
            height=6,
            cell_size=0.1,
            section_size=0.5,
            cell_thickness=0.6,
            section_thickness=1.0,
            cell_color=palette.cell,
            section_color=palette.section,
            infinite_grid=False,
            fade_distance=6,
            fade_from="origin",
            fade_strength=1.2,
            shadow_opacity=0.3,
            plane_opacity=0.0,
        )
        return
    ticks = np.arange(-3.0, 3.01, 0.5)
    ends = np.full_like(ticks, 3.0)
    zero = np.zeros_like(ticks)
    along = np.stack([np.stack([ticks, -ends, zero], -1), np.stack([ticks, ends, zero], -1)], 1)
    lines = np.concatenate([along, along[..., [1, 0, 2]]]).astype(np.float32)
    scene.add_line_segments("/floor", lines, palette.section, thickness=1, thickness_units="screen")
