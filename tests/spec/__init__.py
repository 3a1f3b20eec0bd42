"""Tests of the specification: files of robots, good and bad, and what is written back into them."""
