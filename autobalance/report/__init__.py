"""Results become JSON, text, pages, sheets; units go out here; nothing is computed."""
