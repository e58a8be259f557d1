"""Mistakes inside of message, service and action files."""

from __future__ import annotations

from launcher.packages.package_origins import clone_commands
from tests.workspace.unit.building.mistakes.cases import ABSENT, FIELD, Case, msg, of_file
from tests.workspace.unit.building.source_tree import interface_package

CONSTANT = "upper case letters, digits and single underscores, beginning with a letter"
NOT_A_FIELD = f"'{{}}' is not a valid field name: {FIELD}"
C_KEYWORD = "'{}' is a keyword of C or C++: the generated code could not be compiled"

ERRORS = {
    # ---- fields of messages
    "an unknown primitive type": msg(
        "int32 a\nint b", 2, "int b", "unknown type 'int'", "write int32"
    ),
    "float": msg("float x", 1, "float", "unknown type 'float'", "write float32 or float64"),
    "a misspelt primitive type": msg(
        "flaot32 x", 1, "flaot32", "unknown type 'flaot32'", "did you mean 'float32'?"
    ),
    "time of ROS 1": msg(
        "time t", 1, "time", "ROS 2 has no type 'time'", "write builtin_interfaces/Time"
    ),
    "header": msg("header h", 1, "header", "unknown type 'header'", "write std_msgs/Header"),
    "Header without its package": msg(
        "Header header", 1, "Header", "unknown type 'Header'", "write std_msgs/Header"
    ),
    "a type with /msg/": msg(
        "std_msgs/msg/String s",
        1,
        "std_msgs",
        "'std_msgs/msg/String' is not a type",
        "write std_msgs/String",
    ),
    "an unknown type of a known package": msg(
        "std_msgs/Strin s",
        1,
        "std_msgs",
        "std_msgs has no message 'Strin'",
        "did you mean 'String'?",
    ),
    "a type of another package": msg(
        "std_msgs/Point p",
        1,
        "std_msgs",
        "std_msgs has no message 'Point'",
        "write geometry_msgs/Point",
    ),
    "a misspelt package": msg(
        "std_msg/String s", 1, "std_msg/", ABSENT.format("std_msg"), "did you mean 'std_msgs'?"
    ),
    "a package without a wheel": msg(
        "tf2_msgs/TFMessage t",
        1,
        "tf2_msgs",
        ABSENT.format("tf2_msgs"),
        f"get its sources, in the workspace's folder: {' && '.join(clone_commands('tf2_msgs'))}",
    ),
    "a package that is not in DEPENDENCIES": msg(
        "geometry_msgs/Point p",
        1,
        "geometry_msgs",
        "'geometry_msgs' is missing in the DEPENDENCIES of rosidl_generate_interfaces",
        "add it in src/m/CMakeLists.txt:6, with find_package(geometry_msgs REQUIRED) before, and "
        "<depend>geometry_msgs</depend> in package.xml",
    ),
    "a misspelt own type": Case(
        interface_package("m", {"msg/Task.msg": "int32 a", "msg/List.msg": "Tsak[] tasks"}),
        "src/m/msg/List.msg:1",
        "Tsak",
        "unknown type 'Tsak'",
        "did you mean 'Task'?",
    ),
    "an own type that is not listed": Case(
        {**interface_package("m", {"msg/List.msg": "Task[] tasks"}), "m/msg/Task.msg": "int8 a"},
        "src/m/msg/List.msg:1",
        "Task",
        "msg/Task.msg is not listed in rosidl_generate_interfaces",
        'add "msg/Task.msg" in src/m/CMakeLists.txt:6',
    ),
    "a field name with capitals": msg(
        "int32 robotId", 1, "robotId", NOT_A_FIELD.format("robotId"), "write 'robot_id'"
    ),
    "a field name with '_' at its end": msg(
        "int32 x_", 1, "x_", NOT_A_FIELD.format("x_"), "write 'x'"
    ),
    "a field name that is not ASCII": msg(
        "int32 größe", 1, "größe", NOT_A_FIELD.format("größe"), None
    ),
    "a keyword of C": msg(
        "int32 default",
        1,
        "default",
        C_KEYWORD.format("default"),
        "use another name, for example 'default_value'",
    ),
    "a keyword of C++": msg(
        "bool class  # of the robot",
        1,
        "class",
        C_KEYWORD.format("class"),
        "use another name, for example 'class_value'",
    ),
    "a field twice": msg("int32 a\n\nint64 a", 3, "a", "'a' is already in line 1", None),
    "a constant twice": msg("int32 A=1\nint64 A=2", 2, "A", "'A' is already in line 1", None),
    "a type alone": msg(
        "int32", 1, "int32", "a field has a type and a name", "write for example 'int32 value'"
    ),
    "an indented line": msg("# x\n  int32 a", 2, "", "the line is indented", "write 'int32 a'"),
    "a semicolon": msg("int32 a;", 1, ";", "a line does not end with ';'", "write 'int32 a'"),
    "two fields in a line": msg(
        "int32 a, b",
        1,
        "a, b",
        "each field needs a separate line",
        "write 'int32 a' and 'int32 b'",
    ),
    "a comment of C": msg(
        "//comment", 1, "//", "a field has a type and a name", "a comment begins with '#'"
    ),
    "'---' in a message": msg(
        "int8 a\n---\nint8 b",
        2,
        "---",
        "a .msg file has one part, without '---'",
        "services are .srv files",
    ),
    # ---- arrays and bounds
    "an array after the name": msg(
        "int32 a[3]", 1, "a[3]", "the size of an array belongs to its type", "write 'int32[3] a'"
    ),
    "an array of 0": msg(
        "int8[0] a",
        1,
        "int8[0]",
        "'0' is not the size of an array: a number above 0",
        "write int8[] for any length, int8[3] for exactly 3, int8[<=3] for at most 3",
    ),
    "an open bracket": msg(
        "int8[ a", 1, "int8[", "the brackets of 'int8[' are wrong", "write int32[3] or int32[]"
    ),
    "a bound of 0": msg(
        "string<=0 s",
        1,
        "string",
        "the bound of a string is a number above 0",
        "write for example string<=10",
    ),
    "a bound with '<'": msg(
        "string<10 s",
        1,
        "string",
        "unknown type 'string<10'",
        "write string<=10 for at most 10 characters",
    ),
    # ---- values
    "a constant out of range": msg(
        "uint8 X=256",
        1,
        "256",
        "'256' is not a value of uint8: must be a valid integer value >= 0 and <= 255",
        None,
    ),
    "a default out of range": msg(
        "int8 x -129",
        1,
        "-129",
        "'-129' is not a value of int8: must be a valid integer value >= -128 and <= 127",
        None,
    ),
    "a decimal comma": msg(
        "float64 x 1,5",
        1,
        "1,5",
        "'1,5' is not a value of float64: must be a floating point number using '.' as the "
        "separator",
        None,
    ),
    "an infinite number": msg(
        "float32 X=inf", 1, "inf", "a value of float32 is a finite number, up to 3.4e+38", None
    ),
    "an infinite number with a comment": msg(
        "float32 X=inf  # x =",
        1,
        "inf",
        "a value of float32 is a finite number, up to 3.4e+38",
        None,
    ),
    "a default that is too long": msg(
        "string<=3 s 'abcd'",
        1,
        "'abcd'",
        "'abcd' is not a value of string<=3: string must not exceed the maximum length of 3 "
        "characters",
        None,
    ),
    "too few elements": msg(
        "int8[3] a [1,2]",
        1,
        "[1,2]",
        "'[1,2]' is not a value of int8[3]: must have exactly 3 elements, not 2",
        None,
    ),
    "a wrong element": msg(
        "bool[] b [true, maybe]",
        1,
        "[true",
        "element 2: 'maybe' is not a value of bool: must be either 'true' / '1' or 'false' / '0'",
        None,
    ),
    "a default of a message": msg(
        "std_msgs/Header h 5",
        1,
        "5",
        "a field of type std_msgs/Header has no default value",
        "remove the value",
    ),
    "a constant in lower case": msg(
        "uint8 idle=1",
        1,
        "idle",
        f"'idle' is not a valid name of a constant: {CONSTANT}",
        "write 'uint8 IDLE=1', or 'uint8 idle 1' for a field with a default value",
    ),
    "a constant without '='": msg(
        "uint8 IDLE 1",
        1,
        "IDLE",
        NOT_A_FIELD.format("IDLE"),
        "write 'uint8 IDLE=1' for a constant",
    ),
    # ---- names of files, parts
    "a name in lower case": of_file(
        "msg/my_msg.msg",
        "int32 a",
        None,
        "",
        "'my_msg' is not a valid name of an interface: letters and digits, beginning with an upper "
        "case letter",
        "rename it to MyMsg.msg",
    ),
    "a byte order mark": msg(
        "\ufeffint32 a",
        1,
        "",
        "the file begins with a byte order mark, which rosidl does not understand",
        "save it as UTF-8 without a byte order mark (BOM)",
    ),
    "a service without '---'": of_file(
        "srv/Add.srv",
        "int32 a\n",
        1,
        "",
        "request and response are separated by 1 line '---', this file has 0",
        None,
    ),
    "a service with '----'": of_file(
        "srv/Add.srv",
        "int32 a\n----\nint32 b\n",
        2,
        "",
        "request and response are separated by 1 line '---', this file has 0",
        "the line must be exactly '---'",
    ),
    "an action with one '---'": of_file(
        "action/Go.action",
        "int32 a\n---\n",
        1,
        "",
        "goal, result and feedback are separated by 2 lines '---', this file has 1",
        None,
    ),
    "a mistake in a response": of_file(
        "srv/Add.srv", "int32 a\n---\nint b\n", 3, "int b", "unknown type 'int'", "write int32"
    ),
    # ---- IDL
    "IDL without a semicolon": of_file(
        "msg/A.idl",
        "module m { module msg {\n  struct A { long c };\n}; };",
        2,
        "};",
        "not understood as IDL",
        "is a ';' missing before it?",
    ),
    "IDL that ends too early": of_file(
        "msg/A.idl",
        "module m { module msg {\n  struct A { long c; };\n};",
        3,
        "",
        "the file ends inside a definition",
        None,
    ),
    "IDL of another name": of_file(
        "msg/A.idl",
        "module m { module msg { struct B { long c; }; }; };",
        1,
        "B {",
        "this file must define m::msg::A, not m::msg::B",
        "the modules are package and folder, the name that of the file",
    ),
    "an unknown type in IDL": of_file(
        "msg/A.idl",
        "module m { module msg {\n struct A { std_msgs::msg::Strin s; }; }; };",
        2,
        "std_msgs",
        "std_msgs has no message 'Strin'",
        "did you mean 'String'?",
    ),
}

WARNINGS = {
    "a keyword of Python": msg(
        "int32 from",
        1,
        "from",
        "'from' is a keyword of Python: the generated module cannot be imported",
        "use another name, for example 'from_value'",
    ),
}
