"""Exports of a run: run file, CSV, PNG and SVG, offline player, Python snippet, lab report.

Every job is a function of plain data at a module's top level, so that `app.runtime.job_pool` can run it in another process.
"""
