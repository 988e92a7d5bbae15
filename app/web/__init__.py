"""The web server: viser behind filters on a socket that we open; only `viser_internals` touches viser's
private side."""
