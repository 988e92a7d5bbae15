"""The page of the lessons: shows and operates the `LessonSession` of the visitor's session."""
