"""File formats, a module for each, with a registry by file ending for reading and writing."""
