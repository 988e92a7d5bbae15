"""A custom law: one function in one file, run in a process of its own, reloaded on save, and tested with reasons."""
