"""The app: a server on this machine and its page, on the public functions alone."""
