"""The claims of a report, measured again."""
