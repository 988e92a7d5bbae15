"""Page of the lessons."""
