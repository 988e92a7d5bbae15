"""A lecture: one plenary session for the whole class, the teacher's control of it, polls, and breakout sessions."""
