"""Benchmarks for developers: peers, many visitors, fairness between them, and waits; see `__main__.py`."""
