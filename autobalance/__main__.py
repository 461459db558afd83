"""``python -m autobalance``."""

from autobalance.command import main

if __name__ == "__main__":
    raise SystemExit(main())
