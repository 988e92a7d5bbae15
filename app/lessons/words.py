"""The sentences that the walkthrough says by itself, in each language. A name in braces is filled in."""

from typing import Final

ENGLISH: Final[dict[str, str]] = {
    "measured": "{label}: {value}",
    "compared": "with {settings}: {value}",
    "reference": "Your run did not get that far, so this is the reference run.",
    "unlike": "This run had {settings}, other than the question is about. Reset and run to see what was asked.",
    "mixed": "The settings changed during the run. Reset, then run again, so that all of it is under the same settings.",
    "unmeasured": "{label}: this run does not tell yet. Let it go on for {seconds}.",
    "passed_low": "{label}: {value}, as asked (at least {bound}).",
    "passed_high": "{label}: {value}, as asked (at most {bound}).",
    "passed_range": "{label}: {value}, as asked ({low} to {high}).",
    "passed_equal": "{label}: {value}, as asked.",
    "too_little": "{label}: {value}, but it must be at least {bound}. {missing} is missing.",
    "too_much": "{label}: {value}, but it must be at most {bound}. That is {missing} too much.",
    "not_equal": "{label}: {value}, but it must be {bound}.",
    "forecast_right": "With {settings} you said {said}, and it is {value}: {error} off, at most {within} is allowed.",
    "forecast_wrong": "With {settings} you said {said}, but it is {value}: {error} off, at most {within} is allowed.",
    "forecast_none": "With {settings}: no number was given.",
    "passed": "Passed.",
    "failed": "Not yet.",
    "right": "You predicted it.",
    "wrong": "It went otherwise.",
}

GERMAN: Final[dict[str, str]] = {
    "measured": "{label}: {value}",
    "compared": "mit {settings}: {value}",
    "reference": "Ihr Lauf kam nicht so weit; dies ist der Vergleichslauf.",
    "unlike": "Dieser Lauf hatte {settings}, anders als gefragt. Zurücksetzen und laufen lassen zeigt, was gefragt war.",
    "mixed": "Die Einstellungen wurden während des Laufs geändert. Bitte zurücksetzen und neu laufen lassen.",
    "unmeasured": "{label}: Dieser Lauf sagt es noch nicht. Lassen Sie ihn {seconds} lang laufen.",
    "passed_low": "{label}: {value}, wie verlangt (mindestens {bound}).",
    "passed_high": "{label}: {value}, wie verlangt (höchstens {bound}).",
    "passed_range": "{label}: {value}, wie verlangt ({low} bis {high}).",
    "passed_equal": "{label}: {value}, wie verlangt.",
    "too_little": "{label}: {value}, es müssen aber mindestens {bound} sein. Es fehlen {missing}.",
    "too_much": "{label}: {value}, es dürfen aber höchstens {bound} sein. Das sind {missing} zu viel.",
    "not_equal": "{label}: {value}, verlangt ist aber {bound}.",
    "forecast_right": "Mit {settings} war Ihre Vorhersage {said}, gemessen {value}: {error} daneben, erlaubt sind {within}.",
    "forecast_wrong": "Mit {settings} war Ihre Vorhersage {said}, gemessen aber {value}: {error} daneben, erlaubt sind {within}.",
    "forecast_none": "Mit {settings}: Es wurde keine Zahl angegeben.",
    "passed": "Bestanden.",
    "failed": "Noch nicht.",
    "right": "Richtig vorhergesagt.",
    "wrong": "Es kam anders.",
}

SLOVENE: Final[dict[str, str]] = {
    "measured": "{label}: {value}",
    "compared": "pri {settings}: {value}",
    "reference": "Vaš poskus ni prišel tako daleč, zato je to primerjalni poskus.",
    "unlike": "V tem poskusu je bilo {settings}, drugače kot v vprašanju. Ponastavite in zaženite znova.",
    "mixed": "Nastavitve so se med poskusom spremenile. Ponastavite in zaženite znova.",
    "unmeasured": "{label}: ta poskus tega še ne pove. Naj teče še {seconds}.",
    "passed_low": "{label}: {value}, kot je zahtevano (najmanj {bound}).",
    "passed_high": "{label}: {value}, kot je zahtevano (največ {bound}).",
    "passed_range": "{label}: {value}, kot je zahtevano (od {low} do {high}).",
    "passed_equal": "{label}: {value}, kot je zahtevano.",
    "too_little": "{label}: {value}, mora pa biti najmanj {bound}. Manjka {missing}.",
    "too_much": "{label}: {value}, sme pa biti največ {bound}. To je {missing} preveč.",
    "not_equal": "{label}: {value}, mora pa biti {bound}.",
    "forecast_right": "Pri {settings} ste napovedali {said}, izmerjeno je {value}: odstopanje {error}, dovoljeno {within}.",
    "forecast_wrong": "Pri {settings} ste napovedali {said}, izmerjeno pa je {value}: odstopanje {error}, dovoljeno {within}.",
    "forecast_none": "Pri {settings}: število ni bilo vpisano.",
    "passed": "Opravljeno.",
    "failed": "Še ne.",
    "right": "Pravilno ste napovedali.",
    "wrong": "Zgodilo se je drugače.",
}

WORDS: Final[dict[str, dict[str, str]]] = {"en": ENGLISH, "de": GERMAN, "sl": SLOVENE}


def say(language: str, sentence: str, **parts: str) -> str:
    """Return a sentence in a language, English if it has none."""
    return WORDS.get(language, ENGLISH).get(sentence, ENGLISH[sentence]).format(**parts)
