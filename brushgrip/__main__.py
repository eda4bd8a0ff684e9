"""`python -m brushgrip`."""

from brushgrip.app import main

if __name__ == "__main__":
    main()
