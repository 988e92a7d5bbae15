"""The robot of the paper: the KUKA LWR 4+, all made by us from its published numbers."""
