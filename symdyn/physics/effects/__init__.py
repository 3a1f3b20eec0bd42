"""One file per effect. A new file is a new effect; nothing else needs to change."""
