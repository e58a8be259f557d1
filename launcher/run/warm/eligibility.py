"""Which processes may be started warm, and why others are started cold."""

from __future__ import annotations

import os

from launcher.packages.python_program import PythonProgram, program_of

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from launcher.base.model.spec import ProcessSpec

# Read by the interpreter, the loader, the C library, or a library when it is loaded: the wheels of
# rclpy (LTTng), numpy (OpenBLAS, gfortran), OpenMP, OpenSSL. What Python code reads while it is
# imported is found out by the preparing process.
_READ_EARLY = ("HOME", "LANG", "LANGUAGE", "TZ", "RMW_IMPLEMENTATION", "RCL_ASSERT_RMW_ID_MATCHES")
_READ_EARLY_PREFIXES = (
    "PYTHON",
    "__PYVENV",
    "_ROS_WHEELS",
    "LD_",
    "LC_",
    "GLIBC_",
    "MALLOC_",
    "LTTNG_",
    "OPENBLAS_",
    "GOTO_",
    "BLIS_",
    "MKL_",
    "OMP_",
    "GOMP_",
    "KMP_",
    "GFORTRAN_",
    "NPY_",
    "NUMPY_",
    "OPENSSL_",
)
# Tools that begin in the interpreter's start: coverage.
_TOOLS = ("COVERAGE_PROCESS_START", "COVERAGE_PROCESS_CONFIG", "COV_CORE_SOURCE")


class Prepared:
    """What the preparing process has reported: the variables that its imports have read, the names
    of the modules that it has loaded, and those that it has left out.
    """

    def __init__(
        self, variables: Collection[str], modules: Collection[str], without: Sequence[str]
    ) -> None:
        self.variables = frozenset(variables)
        self.modules = frozenset(modules)
        self.without = tuple(without)


def folder_of(program: PythonProgram, cwd: str) -> str:
    """The first entry of its `sys.path`."""
    script = os.path.join(cwd, program.script)
    return os.path.dirname(os.path.realpath(script)) if program.script else cwd


def judge(spec: ProcessSpec, env: Mapping[str, str], cwd: str) -> PythonProgram | str:
    """What would be forked, or why it cannot, whatever was prepared; `cwd` is its folder."""
    if spec.shell:
        return "a shell runs it"
    program = program_of(spec.argv, env, spec.cwd)
    if isinstance(program, str):
        return program
    tool = next((name for name in _TOOLS if env.get(name)), None)
    if tool is not None:
        return f"{tool} is set"
    if not os.path.isdir(cwd):
        return f"'{cwd}' is no folder"
    paths = env.get("PYTHONPATH", "").split(os.pathsep)
    if env.get("PYTHONPATH") and not all(map(os.path.isabs, paths)):
        return "PYTHONPATH has a relative path"
    return program


def obstacle(
    folder: str, env: Mapping[str, str], base: Mapping[str, str], prepared: Prepared | None
) -> str | None:
    """Why a program cannot be forked from what was prepared with the environment `base`.

    `folder` is the first in its `sys.path`. None: nothing is in the way, as far as it is known.
    """
    if env is not base:
        for name in sorted(env.keys() | base.keys()):
            if env.get(name) != base.get(name) and _is_read_early(name, prepared):
                return f"its {name} is not that of what was prepared"
    if prepared is not None and (hidden := _hidden_by(folder, prepared.modules)):
        return f"'{hidden}' in its folder hides a module that was prepared"
    return None


def _is_read_early(name: str, prepared: Prepared | None) -> bool:
    if name in _READ_EARLY or name.startswith(_READ_EARLY_PREFIXES):
        return True
    return prepared is not None and name in prepared.variables


def _hidden_by(folder: str, modules: frozenset[str]) -> str | None:
    """A file or package in the folder with the name of one of these modules."""
    try:
        names = os.listdir(folder)
    except OSError:
        return None
    for name in names:
        top, dot, suffix = name.partition(".")
        if top in modules:
            is_module = (
                suffix == "py" or suffix.endswith("so") if dot else _is_package(folder, name)
            )
            if is_module:
                return name
    return None


def _is_package(folder: str, name: str) -> bool:
    return os.path.isfile(os.path.join(folder, name, "__init__.py"))
