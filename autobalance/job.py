"""A TOML job becomes dataclasses; outside units come in here."""
