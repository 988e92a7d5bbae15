"""Handles on the `scene` of the operator's client, which move things of the `session`."""
