"""Options that name a custom law's file. Imports nothing slow."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Final

import tyro

from app.hosting.serve_options import FeatureOptions, ServeOptions
from app.recording.run_source import RunSource
from app.web.origin_policy import OriginPolicy
from controllers.errors import BadInputFile, BadSetting
from scenes.files import readable

if TYPE_CHECKING:
    from app.recording.headless_law import HeadlessLaw

EDITED: Final = Path("my_law.py")


@dataclass(frozen=True)
class CustomLawOptions(FeatureOptions):
    """A law of a file, in every session, and its editor."""

    in_brief: ClassVar[tuple[str, ...]] = ("edit_law",)

    law_file: Path | None = None
    """A law of your own, see `new-law`: it runs instead of ours, and is loaded again whenever it is saved."""
    edit_law: bool = False
    """Edit a law on the page, that of --law-file or my_law.py of this folder: in lesson 10 and in Compare, on this computer only."""
    unnamed: tyro.conf.Suppress[Path] = EDITED
    """File to edit if `law_file` names none."""

    @property
    def edited(self) -> Path | None:
        return (self.law_file or self.unnamed).absolute() if self.edit_law else None

    def existing_file(self) -> Path | None:
        """File that runs in every session, or None.

        Raises:
            BadInputFile: it does not exist.
        """
        path = self.law_file
        if path is not None and not path.is_file():
            raise BadInputFile(
                f"{path}: there is no such file; `lwr-duet new-law {path}` writes one to begin with."
            )
        return path

    def fits(self, options: ServeOptions) -> None:
        """Refuse the editor if others could reach the page: a law is a program."""
        if not self.edit_law:
            return
        shared = {
            f"--host {readable(options.host)}": not OriginPolicy(options.host, options.port).is_private,
            "--allow-origin": options.allowed_origins,
            **{one.shared_by: True for one in options.features if one.shared_by},
            "--embed-origin": options.embed_origins,
        }
        for option, given in shared.items():
            if given:
                raise BadSetting(
                    f"--edit-law is not possible with {option}: a law is a program, and only you may write it. Leave out one of the "
                    "two; students edit theirs on their own computer, or in the tile of a notebook server."
                )


@dataclass(frozen=True)
class RunLawOptions(RunSource):
    """A law of a file."""

    law_file: Path | None = None
    """A law of your own, see `new-law`, instead of one of ours."""

    @property
    def given(self) -> Mapping[str, Path]:
        return {}

    @property
    def read(self) -> tuple[Path, ...]:
        return () if self.law_file is None else (self.law_file,)

    def law(self) -> "HeadlessLaw | None":
        if self.law_file is None:
            return None
        from app.features.custom_law.custom_law import CustomLaw

        return CustomLaw(self.law_file, waits=True)
