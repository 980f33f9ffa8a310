"""Mutation tests: faults are planted in the library, one at a time, and the tests that catch each are named."""
