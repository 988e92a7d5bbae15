"""A lecture's command-line options: refused values, messages at the start, use in every process."""

import pickle
import re
import socket

import pytest

from app.__main__ import run_command as main
from app.features.lecture.lecture_options import LectureOptions
from app.features.workers.worker_messages import WorkerStart
from app.hosting.serve_options import ServeOptions
from app.runtime.terminal import INTERRUPTED
from app.start import App
from tests.app.cli.test_commands import refused
from tests.approved import Approve

REFUSED = (
    "--watchers 0",
    "--lecture --students 2001",
    "--lecture --students -1",
    "--edit-law --lecture",
)


def test_one_line_says_what_is_wrong(capsys: pytest.CaptureFixture[str], approve: Approve) -> None:
    said = (f"{one}\n{refused(capsys, 'serve', *one.split())}\n" for one in REFUSED)
    approve("refused options.txt", "\n".join(said))


def test_the_help_names_the_options(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    with pytest.raises(SystemExit):
        main(["serve", "--help-all"])
    said = capsys.readouterr().out
    assert [
        text
        for text in ("--lecture", "--watchers", "--students", "A class: all tabs see")
        if text not in said
    ] == []


def test_one_or_several_processes_get_the_commands_options(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    served: list[ServeOptions] = []

    def alone(options: ServeOptions, *_: object, **__: object) -> App:
        served.append(options)
        raise KeyboardInterrupt

    def behind(_: socket.socket, start: WorkerStart, most: int) -> None:
        # Messages to a worker are pickled.
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


def test_the_start_names_the_address_of_the_class_and_the_groups(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], approve: Approve
) -> None:
    places: list[int | None] = []

    def wait(app: App) -> None:
        places.append(app.server.max_clients)
        raise KeyboardInterrupt

    monkeypatch.setattr(App, "wait", wait)
    given = ["serve", "--no-open", "--store", "memory", "--port", "0", "--workers", "1", "--sessions", "8"]
    assert main([*given, "--lecture", "--watchers", "7", "--students", "30"]) == INTERRUPTED
    said = capsys.readouterr().out
    approve("start with groups.txt", re.sub(r"http://[^\s/]+", "http://…", said))
    assert main([*given, "--lecture"]) == INTERRUPTED
    said = capsys.readouterr().out
    assert "The class opens" in said and "groups" not in said
    assert main([*given, "--students", "30"]) == INTERRUPTED
    assert "class" not in capsys.readouterr().out
    assert places == [7, 200, 8]
