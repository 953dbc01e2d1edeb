"""What every table of the spec file shares: its base class, validation, and suggestions for unknown keys."""
