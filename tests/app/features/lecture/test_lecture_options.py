"""The options of a lecture on the command line: what they refuse, what the start says, and that every process gets them."""

import pickle
import socket

import pytest

from app.__main__ import run_command as main
from app.features.lecture.lecture_options import LectureOptions
from app.features.workers.worker_messages import WorkerStart
from app.hosting.serve_options import ServeOptions
from app.runtime.terminal import INTERRUPTED
from app.start import App
from tests.app.cli.test_commands import refused


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("--watchers 0", "--watchers must be at least 1."),
        ("--lecture --students 2001", "--students must be 0 to 2000"),
        ("--lecture --students -1", "--students must be 0 to 2000"),
        ("--edit-law --lecture", "--edit-law is not possible with --lecture: a law is a program"),
    ],
)
def test_one_line_says_what_is_wrong(capsys: pytest.CaptureFixture[str], arguments: str, said: str) -> None:
    assert said in refused(capsys, "serve", *arguments.split())


def test_the_help_names_the_options(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    with pytest.raises(SystemExit):
        main(["serve", "--help-all"])
    said = capsys.readouterr().out
    assert [
        text
        for text in ("--lecture", "--watchers", "--students", "A class: all tabs see one shared session")
        if text not in said
    ] == []


def test_alone_or_behind_the_door_the_app_gets_what_the_command_was_given(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    served: list[ServeOptions] = []

    def alone(options: ServeOptions, *_: object, **__: object) -> App:
        served.append(options)
        raise KeyboardInterrupt

    def behind(_: socket.socket, start: WorkerStart, most: int) -> None:
        # As the messages to a worker carry it.
        alone(pickle.loads(pickle.dumps(start)).options)

    monkeypatch.setattr("app.start.start_app", alone)
    monkeypatch.setattr("app.features.workers.start.Dispatcher", behind)
    given = ["serve", "--store", "memory", "--port", "0"]
    for workers in ("1", "2"):
        assert (
            main([*given, "--lecture", "--watchers", "7", "--students", "60", "--workers", workers])
            == INTERRUPTED
        )
        assert main([*given, "--workers", workers]) == INTERRUPTED
    asked = LectureOptions(watchers=7, students=60, lecture=True)
    assert [one.of(LectureOptions) for one in served] == [asked, LectureOptions()] * 2
    assert [one.shared for one in served] == [asked, None] * 2 and ServeOptions().of(
        LectureOptions
    ) == LectureOptions()


def test_the_start_says_the_address_of_the_class_and_the_groups(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    places: list[int | None] = []

    def wait(app: App) -> None:
        places.append(app.server.max_clients)
        raise KeyboardInterrupt

    monkeypatch.setattr(App, "wait", wait)
    given = ["serve", "--no-open", "--store", "memory", "--port", "0", "--workers", "1", "--sessions", "8"]
    assert main([*given, "--lecture", "--watchers", "7", "--students", "30"]) == INTERRUPTED
    said = capsys.readouterr().out
    assert "The class opens http://" in said and "30 students, room for 8: groups of 4." in said
    assert main([*given, "--lecture"]) == INTERRUPTED
    assert "The class opens" in (said := capsys.readouterr().out) and "groups" not in said
    assert main([*given, "--students", "30"]) == INTERRUPTED
    assert "class" not in capsys.readouterr().out
    assert places == [7, 200, 8]
