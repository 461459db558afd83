"""Strict reading of TOML: keys, tables, units that people type, settings from outside."""
