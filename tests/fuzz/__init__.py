"""Fuzzers: one per format that others may have written."""
