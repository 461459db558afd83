"""The engine as a rigid body on its mounts."""
