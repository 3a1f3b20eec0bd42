"""What a diagnosis finds on recordings of real machines, rig by rig; writes docs/recordings.md."""
