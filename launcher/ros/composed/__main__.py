"""See the package."""

from launcher.ros.composed.member_group import main

if __name__ == "__main__":
    main()
