"""The modules of tools and extensions of ROS that launch files import from, as `compat_table`."""

MODULES = {
    "ros2launch.api": {
        "launcher.language.ros.cli_api": (
            "LaunchFileNameCompleter MultipleLaunchFilesError get_launch_file_paths "
            "get_share_file_path_from_package is_launch_file launch_a_launch_file "
            "parse_launch_arguments print_a_launch_file print_arguments_of_launch_description "
            "print_arguments_of_launch_file"
        ),
        "launcher.language.sources": "InvalidLaunchFileError InvalidPythonLaunchFileError",
    },
    "ros2launch": {},
    "ros2pkg": {},
    "tracetools_launch": {},
    "tracetools_launch.action": {"launcher.language.actions.trace": "Trace"},
    "ros2pkg.api": {
        "launcher.language.ros.cli_api": (
            "PackageNotFound get_executable_paths get_package_names get_prefix_path "
            "package_name_completer"
        ),
    },
}

SUBMODULES = {
    "ros2launch.api": {
        "api": (
            "LaunchFileNameCompleter MultipleLaunchFilesError get_launch_file_paths "
            "get_share_file_path_from_package is_launch_file launch_a_launch_file "
            "parse_launch_arguments print_a_launch_file print_arguments_of_launch_description "
            "print_arguments_of_launch_file"
        ),
    },
}
