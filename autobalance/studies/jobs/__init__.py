"""The archive of jobs and statistics of a series."""
