"""What compiles: the compiler, CMake files that correct those of the wheels, versions of tools."""
