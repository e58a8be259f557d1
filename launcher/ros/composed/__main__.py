"""See the package."""

from launcher.ros.composed.group import main

if __name__ == "__main__":
    main()
