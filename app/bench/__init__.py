"""A visitor without a browser, for tests and for the benchmark. Knows viser's wire format, not its Python classes."""
