"""What a person calls the numbers that are measured, in each language."""

from typing import Final

from app.lessons.lesson import Compared, Measurement
from app.lessons.measures import QUANTITIES, shown_parameter
from app.lessons.runs import settings_text
from app.lessons.sentences import say
from app.settings import Settings
from scenes.settings import specs

LABELS: Final[dict[str, dict[str, str]]] = {
    "de": {
        "null_dimension": "Bewegungsarten, die die Aufgabe der Hand nicht stören",
        "hand_error_now": "Handfehler jetzt",
        "largest_hand_error": "größter Handfehler",
        "hand_error_at": "Handfehler nach {time}",
        "elbow_travel": "Weg zwischen den entferntesten Orten des Ellbogens",
        "mark_miss": "kleinster Abstand des Ellbogens von der Marke bei {angle}",
        "drift_per_lap": "Drift der Spitze in einer Runde",
        "joint_drift_per_lap": "Drift der Gelenke in einer Runde",
        "lap_error": "größter Handfehler der letzten Runde",
        "distance_now": "Abstand jetzt",
        "smallest_distance": "kleinster Abstand",
        "distance_margin": "kleinstes d − d_m",
        "distance_at": "Abstand nach {time}",
        "way_made": "Weg zum Hindernis hin",
        "largest_approach": "schnellste Annäherung des Hindernisses",
        "approach_now": "Annäherung des Hindernisses jetzt",
        "pull_now": "u jetzt",
        "lever_now": "|J_d| jetzt",
        "activation_now": "λ jetzt",
        "velocity_step": "größter Schritt einer Gelenkgeschwindigkeit",
        "first_jump": "Sprung der Gelenkgeschwindigkeit",
        "switch_pull": "u beim Umschalten",
        "switch_lever": "|J_d| beim Umschalten",
    },
    "sl": {
        "null_dimension": "načini gibanja, ki ne motijo naloge roke",
        "hand_error_now": "pogrešek roke zdaj",
        "largest_hand_error": "največji pogrešek roke",
        "hand_error_at": "pogrešek roke po {time}",
        "elbow_travel": "pot med najbolj oddaljenima mestoma komolca",
        "mark_miss": "najmanjša razdalja komolca od oznake pri {angle}",
        "drift_per_lap": "lezenje vrha na krog",
        "joint_drift_per_lap": "lezenje sklepov na krog",
        "lap_error": "največji pogrešek roke v zadnjem krogu",
        "distance_now": "razdalja zdaj",
        "smallest_distance": "najmanjša razdalja",
        "distance_margin": "najmanjši d − d_m",
        "distance_at": "razdalja po {time}",
        "way_made": "pot proti oviri",
        "largest_approach": "najhitrejše približevanje ovire",
        "approach_now": "približevanje ovire zdaj",
        "pull_now": "u zdaj",
        "lever_now": "|J_d| zdaj",
        "activation_now": "λ zdaj",
        "velocity_step": "največji korak hitrosti sklepa",
        "first_jump": "skok hitrosti sklepov",
        "switch_pull": "u ob preklopu",
        "switch_lever": "|J_d| ob preklopu",
    },
}
"""Language → name of the measurement → label, of those that the translated lessons use; English labels stand with the measurements."""


def label_of(m: Measurement, language: str = "en") -> str:
    """Return what a person calls a measurement, as the beginning of a sentence; {angle} and the like in a label are its parameters."""
    parameters = dict(m.parameters)
    if m.name == "setting":
        return specs(Settings)[str(parameters["key"])].label
    label = LABELS.get(language, {}).get(m.name, QUANTITIES[m.name].label)
    text = label.format(**{name: shown_parameter(name, value) for name, value in parameters.items()})
    # A word gets a capital, a symbol such as d, λ or u does not.
    return text[0].upper() + text[1:] if text[:2].isalpha() and text[:2].islower() else text


def compared_text(compared: Compared, language: str = "en") -> str:
    """Return in what a further run differs: "n = 2", "the ball 100 mm off the goal"."""
    parts = [settings_text(compared.changes)] if compared.changes else []
    ball = compared.start.ball if compared.start is not None else None
    if ball is not None:
        off = say(language, "ball_off", gap=shown_parameter("gap", ball.gap), origin=say(language, f"at_{ball.origin}"))
        beside = say(language, "ball_beside", angle=shown_parameter("angle", ball.tilt)) if ball.toward == "upper_arm" else ""
        parts.append(off + beside)
    elif compared.start is not None:
        parts.append(say(language, "elsewhere"))
    return ", ".join(parts)
