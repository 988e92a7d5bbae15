"""Options of `lwr-duet serve` for a lecture. Imports nothing slow."""

from dataclasses import dataclass
from typing import ClassVar, Final

from app.features.classroom.breakout_places import group_size
from app.hosting.serve_options import FeatureOptions
from controllers.errors import BadSetting

MOST_STUDENTS: Final = 2000


@dataclass(frozen=True)
class LectureOptions(FeatureOptions):
    """A class in front of one shared session."""

    in_brief: ClassVar[tuple[str, ...]] = ("lecture",)

    watchers: int = 200
    """Most pages open in a lecture at once; visitors with the key always get in."""
    students: int = 0
    """In a lecture, how many students are expected: with fewer places than that they explore in groups, which the start says."""
    lecture: bool = False
    """A class: all tabs see one shared session, students answer on their own; the first tab, or the one with the key, leads.
    Then --sessions is how many students at most explore by themselves."""

    @property
    def shared_by(self) -> str:
        return "--lecture" if self.lecture else ""

    @property
    def most_pages(self) -> int | None:
        """Without the teacher, who gets in additionally."""
        return self.watchers if self.lecture else None

    def check(self) -> None:
        if self.watchers < 1:
            raise BadSetting("--watchers must be at least 1.")
        if not 0 <= self.students <= MOST_STUDENTS:
            raise BadSetting(f"--students must be 0 to {MOST_STUDENTS}; 0 if it is not known.")

    def said_at_start(self, host: str, port: int, places: int) -> tuple[str, ...]:
        if not self.lecture:
            return ()
        from app.web.address import find_address

        opened, size = (
            f"The class opens {find_address('', host, port).url}",
            group_size(self.students, places),
        )
        return (
            (opened, f"{self.students} students, room for {places}: groups of {size}.")
            if size > 1
            else (opened,)
        )
