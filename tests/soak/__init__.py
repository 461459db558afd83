"""Random cases by the hour, and those that were ever found, again in every run of the tests."""
