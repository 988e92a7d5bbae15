"""The robot of the paper, made from published numbers."""
