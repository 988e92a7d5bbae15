"""The web server: viser on a socket of ours, behind filters of ours; what touches its private side is `viser_internals`."""
