"""The public functions, one file a verb: thin, over the rooms below; nothing is printed, nothing exits."""
