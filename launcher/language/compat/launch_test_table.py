"""The modules that tests of launch files import; few runs need them, so they are a table apart."""

MODULES = {
    "launch_pytest": {"launcher.smoke.launch_tests.launch_fixtures": "fixture"},
    "launch_pytest.actions": {"launcher.language.testing": "ReadyToTest"},
    "launch_pytest.fixture": {
        "launcher.smoke.launch_tests.launch_fixtures": "finalize_launch_service fixture",
    },
    "launch_pytest.plugin": {"launcher.smoke.launch_tests.launch_items": "LaunchTestWarning"},
    "launch_pytest.tools": {
        "launcher.smoke.launch_tests.process_waits": (
            "assert_output assert_output_sync assert_stderr assert_stderr_sync wait_for_exit "
            "wait_for_exit_sync wait_for_output wait_for_output_sync wait_for_start "
            "wait_for_start_sync wait_for_stderr wait_for_stderr_sync"
        ),
    },
    "launch_testing": {
        "launcher.language.testing": "parametrize post_shutdown_test ready_to_test_action_timeout",
        "launcher.smoke.launch_tests.observations": (
            "ActiveIoHandler ActiveProcInfoHandler IoHandler ProcInfoHandler ReadyAggregator"
        ),
    },
    "launch_testing.actions": {
        "launcher.language.testing": "ReadyToTest",
        "launcher.smoke.launch_tests.test_actions": "GTest PyTest",
    },
    "launch_testing.actions.test": {"launcher.smoke.launch_tests.test_actions": "Test"},
    "launch_testing.asserts": {
        "launcher.smoke.launch_tests.asserts": (
            "EXIT_OK EXIT_SIGINT EXIT_SIGKILL EXIT_SIGQUIT EXIT_SIGSEGV SequentialTextChecker "
            "assertDefaultStream assertExitCodes assertInStderr assertInStdout assertInStream "
            "assertSequentialStdout"
        ),
        "launcher.smoke.launch_tests.process_lookup": "NO_CMD_ARGS",
    },
    "launch_testing.decorator": {"launcher.language.testing": "post_shutdown_test"},
    "launch_testing.event_handlers": {
        "launcher.smoke.launch_tests.test_actions": "StdoutReadyListener",
    },
    "launch_testing.junitxml": {
        "launcher.smoke.launch_tests.junit": (
            "unittestCaseToXml unittestResultToXml unittestResultsToXml"
        ),
    },
    "launch_testing.launch_test": {"launcher.__main__": "main=launch_test"},
    "launch_testing.legacy": {"launcher.smoke.launch_tests.legacy": "LaunchTestService"},
    "launch_testing.legacy.output": {
        "launcher.smoke.launch_tests.legacy": (
            "create_output_lines_filter create_output_lines_test create_output_regex_test "
            "create_output_test_from_file"
        ),
    },
    "launch_testing.loader": {
        "launcher.smoke.launch_tests.loading": (
            "LoadTestsFromPythonModule PostShutdownTestLoader PreShutdownTestLoader TestRun"
        ),
    },
    "launch_testing.markers": {"launcher.language.testing": "keep_alive retry_on_failure"},
    "launch_testing.parse_arguments": {
        "launcher.language.ros.cli_api": "parse_launch_arguments",
    },
    "launch_testing.print_arguments": {
        "launcher.language.ros.cli_api": "print_arguments_of_launch_description",
    },
    "launch_testing.pytest": {},
    "launch_testing.pytest.hooks": {
        "launcher.smoke.launch_tests.test_modules": (
            "LaunchTestFailure LaunchTestItem LaunchTestModule"
        ),
    },
    "launch_testing.test_result": {
        "launcher.smoke.launch_tests.results": "FailResult SkipResult TestResult",
    },
    "launch_testing.test_runner": {
        "launcher.smoke.launch_tests.running": "LaunchTestRunner _RunnerWorker=RunnerWorker",
    },
    "launch_testing.tools": {
        "launcher.smoke.launch_tests.process_proxy": "ProcessProxy launch_process",
        "launcher.smoke.launch_tests.text_matching": (
            "basic_output_filter expect_output expected_output_from_file"
        ),
    },
    "launch_testing.tools.output": {
        "launcher.smoke.launch_tests.text_matching": (
            "basic_output_filter expect_output expected_output_from_file "
            "get_default_filtered_patterns get_default_filtered_prefixes"
        ),
    },
    "launch_testing.tools.text": {
        "launcher.smoke.launch_tests.text_matching": (
            "build_line_match build_text_match normalize_lineseps"
        ),
    },
    "launch_testing.util": {
        "launcher.language.testing": "KeepAliveProc",
        "launcher.smoke.launch_tests.process_lookup": (
            "NO_CMD_ARGS NoMatchingProcessException resolveProcesses"
        ),
    },
    "launch_testing_ros": {
        "launcher.ros.topics.test_nodes": "DataRepublisher MessagePump WaitForTopics",
        "launcher.smoke.launch_tests.running": "LaunchTestRunner",
    },
    "launch_testing_ros.actions": {"launcher.smoke.launch_tests.ros_tools": "EnableRmwIsolation"},
    "launch_testing_ros.tools": {
        "launcher.smoke.launch_tests.ros_tools": "basic_output_filter get_rmw_output_filter",
    },
}

# As in `compat_table`: package -> submodule -> names, which are those of the package.
SUBMODULES = {
    "launch_pytest.tools": {
        "process": (
            "assert_output assert_output_sync assert_stderr assert_stderr_sync wait_for_exit "
            "wait_for_exit_sync wait_for_output wait_for_output_sync wait_for_start "
            "wait_for_start_sync wait_for_stderr wait_for_stderr_sync"
        ),
    },
    "launch_testing": {
        "io_handler": "ActiveIoHandler IoHandler",
        "parametrize": "parametrize",
        "proc_info_handler": "ActiveProcInfoHandler ProcInfoHandler",
        "ready_aggregator": "ReadyAggregator",
        "ready_to_test_action_timeout": "ready_to_test_action_timeout",
    },
    "launch_testing.actions": {"gtest": "GTest", "pytest": "PyTest", "ready": "ReadyToTest"},
    "launch_testing.asserts": {
        "assert_exit_codes": (
            "EXIT_OK EXIT_SIGINT EXIT_SIGKILL EXIT_SIGQUIT EXIT_SIGSEGV assertExitCodes"
        ),
        "assert_output": "assertDefaultStream assertInStderr assertInStdout assertInStream",
        "assert_sequential_output": "SequentialTextChecker assertSequentialStdout",
    },
    "launch_testing.event_handlers": {"stdout_ready_listener": "StdoutReadyListener"},
    "launch_testing.tools": {"process": "ProcessProxy launch_process"},
    "launch_testing.util": {
        "proc_lookup": "NO_CMD_ARGS NoMatchingProcessException resolveProcesses",
    },
    "launch_testing_ros": {
        "data_republisher": "DataRepublisher",
        "message_pump": "MessagePump",
        "test_runner": "LaunchTestRunner",
        "wait_for_topics": "WaitForTopics",
    },
    "launch_testing_ros.actions": {"enable_rmw_isolation": "EnableRmwIsolation"},
    "launch_testing_ros.tools": {"output": "basic_output_filter get_rmw_output_filter"},
}
