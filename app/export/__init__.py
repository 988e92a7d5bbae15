"""What is kept of a run: a file, a table, pictures, a film with a scrubber, a page that plays without a server, a snippet, a report.

Everything that takes longer than a frame is a function of plain data at a module's top level, whose last argument is `stopped`, so
that `app.runtime.job_pool` can have it done elsewhere.
"""
