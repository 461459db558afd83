"""One file a format; a registry by file ending; reading and writing through it."""
