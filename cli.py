"""The way in from a checkout: ``python cli.py balance JOB.toml``."""

from autobalance.command import main

if __name__ == "__main__":
    raise SystemExit(main())
