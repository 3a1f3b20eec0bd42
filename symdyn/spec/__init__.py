"""The specification: a robot as frozen data, read from TOML with file:line:column errors."""
