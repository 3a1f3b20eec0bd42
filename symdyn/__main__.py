"""``python -m symdyn`` is the ``symdyn`` command."""

from symdyn.faces.cli import main

if __name__ == "__main__":
    main()
