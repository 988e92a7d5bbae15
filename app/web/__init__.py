"""The web server: viser, locked down. Everything that touches viser's insides is here, and in `app.web.audiences`.

viser has no public way to look at a request or at a message before it acts on it. It does build its server with
`websockets.asyncio.server.serve`, so we hand it a listening socket of our own, a connection class that filters what it reads,
and a function that answers the requests which are ours. All of this relies on viser 1.1; the tests of this folder notice when viser
changes.
"""
