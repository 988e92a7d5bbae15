"""The page of the lessons: made by the visitor's `gui`, it shows and operates `run`, the lessons of their `session`."""
