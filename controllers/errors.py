"""What can go wrong through no fault of the program: errors a person can read and put right."""

from __future__ import annotations


class DuetError(Exception):
    """Something the person at the keyboard can put right.

    The message is one line: what is wrong, then the valid choices or the remedy. It is shown as it is, without a traceback.
    """


class BadSetting(DuetError):
    """A setting lies outside its range or is unknown; the message names the setting and what would be valid."""


class BadInputFile(DuetError):
    """A file can't be used: missing, unreadable, of the wrong kind or inconsistent; the message names the file and the reason."""
