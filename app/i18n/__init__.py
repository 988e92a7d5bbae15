"""The page's texts in other languages than English; see README.md."""
