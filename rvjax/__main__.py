"""`python -m rvjax` is the program `rvjax`."""

from rvjax.cli import main

if __name__ == "__main__":
    main()
