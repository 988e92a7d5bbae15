"""Marks for what a class hands in: points of laws and lab reports, tables for other systems, and a page of feedback for every student."""
