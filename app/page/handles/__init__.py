"""Handles on the `scene` of the operator's client; a drag moves what is theirs in their `session`."""
