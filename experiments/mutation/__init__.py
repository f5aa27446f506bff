"""Mutation testing: whether the tests notice a change of one operator, comparison or number."""
