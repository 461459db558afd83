"""Results become JSON, text, pages and sheets; units are converted here, and nothing is computed."""
