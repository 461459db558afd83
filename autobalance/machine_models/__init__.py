"""A job and a crank become what is computed with: a rotor, an engine, a chain of inertias."""
