"""A blind benchmark for tools that find missing physics: name, place and value, on plants they cannot see."""
