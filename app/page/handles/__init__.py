"""What can be taken hold of, drawn on the `scene` of the client that has the controls; a drag moves what is theirs in their `session`."""
