"""`launcher wheel`: built packages of a workspace as wheels.

Installed by pip, a wheel of a message package works as those of ROS do: libraries are in the `lib/`
of the environment, the ament index and the CMake files in `share/`.
"""
