"""The web server: viser behind filters; only `viser_internals` touches viser's private side."""
