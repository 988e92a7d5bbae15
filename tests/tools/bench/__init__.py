"""Benchmarks for developers: peers, many visitors, fairness between them, and waits; see `tests/tools/bench/__main__.py`."""
