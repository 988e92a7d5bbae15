"""The web server: viser, locked down.

viser builds its server with `websockets.asyncio.server.serve`. We hand it a listening socket of our own, a connection class that filters
what it reads, and a function that answers the requests which are ours. What this needs of viser's private side is in
`app.web.viser_internals`.
"""
