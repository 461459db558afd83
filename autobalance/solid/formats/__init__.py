"""File formats, a module for each; a registry by file ending; reading and writing through it."""
