"""The panels of controls, numbers and plots.

A panel is made by the visitor's `gui` in a container that the caller has opened, and operates their `session`; `notify` shows them a
title and a text, `show` draws a frame.
"""
