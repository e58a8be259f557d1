"""Mistakes in setup.py and setup.cfg."""

from __future__ import annotations

from tests.workspace.unit.building.mistakes.cases import Case
from tests.workspace.unit.building.source_tree import python_package


def python(
    old: str, new: str, line: int, at: str, message: str, hint: str | None, **files: str | None
) -> Case:
    """An ament_python package `p`, with one replacement in its setup.py."""
    texts = python_package("p")
    setup = texts["p/setup.py"]
    assert old in setup
    texts = python_package("p", setup_py=setup.replace(old, new), **files)
    return Case(texts, f"src/p/setup.py:{line}", at, message, hint)


def own_module(module: str, folder: str) -> dict[str, str]:
    """The package `my_robot` with a console script of `module`; its modules are in `folder`."""
    setup_py = f"""\
        from setuptools import find_packages, setup
        setup(name='my_robot', packages=find_packages(), entry_points={{'console_scripts': [
            'talker={module}.talker:main']}},
            data_files=[('share/ament_index/resource_index/packages', ['resource/my_robot'])])
        """
    texts = python_package("my_robot", setup_py=setup_py)
    old, new = "my_robot/my_robot/", f"my_robot/{folder}/"
    return {path.replace(old, new): text for path, text in texts.items()}


ERRORS = {
    "a syntax error in setup.py": python(
        "version='0.1.0',", "version='0.1.0'", 5, "'0.1.0'", "syntax error: {syntax}", None
    ),
    "no resource marker": python(
        "'setuptools'",
        "'setuptools'",
        8,
        "'resource/p'",
        "the file 'resource/p' in data_files does not exist",
        "create it, an empty file: touch resource/p",
        marker=None,
    ),
    "a data file": python(
        "['package.xml']",
        "['packages.xml']",
        9,
        "'packages.xml'",
        "the file 'packages.xml' in data_files does not exist",
        "did you mean 'package.xml'?",
    ),
    "a folder as data file": python(
        "['package.xml']",
        "['package.xml', 'resource']",
        9,
        "'resource'",
        "'resource' in data_files is not a file",
        "it is a folder: write glob('resource/*')",
    ),
    **{
        f"a setup.py without setup(): {text!r}": Case(
            python_package("p", setup_py=text),
            "src/p/setup.py",
            "",
            "does not call setup()",
            "write: from setuptools import setup; setup(name='p', ...)",
        )
        for text in (
            "",
            "print('hello')\n",
            "import os\nfrom setuptools import find_packages, setup\nfind_packages()\n",
        )
    },
    "a Python package that does not exist": python(
        "find_packages(exclude=['test'])",
        "['pp']",
        6,
        "'pp'",
        "the Python package 'pp' does not exist: there is no folder of this name",
        None,
    ),
    "a Python package after umlauts": python(
        "find_packages(exclude=['test'])",
        "['p' or 'äöü', 'pp']",
        6,
        "'pp'",
        "the Python package 'pp' does not exist: there is no folder of this name",
        None,
    ),
    "a console script without an equals sign": python(
        "talker = p.talker:main",
        "talk p.talker:main",
        12,
        "'talk ",
        "the console script 'talk p.talker:main' must have the form NAME = MODULE:FUNCTION",
        "write 'talk = p.talker:main'",
    ),
    "a console script without a name": python(
        "talker = p.talker:main",
        "p.talker:main",
        12,
        "'p.talker",
        "the console script 'p.talker:main' must have the form NAME = MODULE:FUNCTION",
        "write 'talker = p.talker:main'",
    ),
    "a console script without a module": python(
        "talker = p.talker:main",
        "talker",
        12,
        "'talker'",
        "the console script 'talker' must have the form NAME = MODULE:FUNCTION",
        "write 'talker = p.talker:main'",
    ),
    **{
        f"a setup.cfg with {text!r}": Case(
            python_package("p", setup_cfg=text), f"src/p/setup.cfg:{line}", "", message, None
        )
        for text, line, message in (
            ("[foo\n", 1, "the line is in no section"),
            ("[foo]\na=1\nb\n", 3, "the line is neither [SECTION] nor KEY = VALUE"),
            ("[foo]\na=1\na=2\n", 3, "'a' is there twice"),
            ("[foo]\na=1\n[foo]\n", 3, "'foo' is there twice"),
        )
    },
}

NOT_FOUND = "the programs are installed in bin/, where ros2 run does not find them"

WARNINGS = {
    "a misspelt module": Case(
        python_package("p", talker=None) | {"p/p/talkre.py": "def main(): pass\n"},
        "src/p/setup.py:12",
        "'talker = ",
        "the module 'p.talker' of the console script 'talker' does not exist",
        "did you mean 'talkre'?",
    ),
    "a misspelt package of a module": Case(
        own_module("my_robt", folder="my_robot"),
        "src/my_robot/setup.py:3",
        "'talker=",
        "the module 'my_robt.talker' of the console script 'talker' does not exist",
        "did you mean 'my_robot'?",
    ),
    "a package whose folder was renamed": Case(
        own_module("my_robot", folder="robot"),
        "src/my_robot/setup.py:3",
        "'talker=",
        "the module 'my_robot.talker' of the console script 'talker' does not exist",
        "did you mean 'robot'?",
    ),
    "a misspelt function": Case(
        python_package(
            "p",
            talker="RATE: int = 1\ndef mian():\n    pass\nif __name__ == '__main__':\n    mian()\n",
        ),
        "src/p/setup.py:12",
        "'talker = ",
        "the module 'p.talker' has no function 'main' for the console script 'talker'",
        "did you mean 'mian'?",
    ),
    "a console script of a module": python(
        "talker = p.talker:main",
        "talk = p.talker",
        12,
        "'talk = ",
        "the console script 'talk = p.talker' must have the form NAME = MODULE:FUNCTION",
        "write 'talk = p.talker:main'",
    ),
    "a console script without a function": python(
        "p.talker:main",
        "p.talker.main",
        12,
        "'talker = p.talker.main'",
        "the console script 'talker = p.talker.main' must have the form NAME = MODULE:FUNCTION",
        "write 'talker = p.talker:main'",
    ),
    "another name in setup.py": python(
        "name='p'",
        "name='q'",
        4,
        "q'",
        "setup.py is about 'q', package.xml about 'p'",
        "write name='p'",
    ),
    "another name in setup.cfg": Case(
        python_package(
            "p",
            setup_py="from setuptools import setup\nsetup(**{})\n",
            setup_cfg="[metadata]\nname = q\n[develop]\nscript_dir=$base/lib/p\n"
            "[install]\ninstall_scripts=$base/lib/p\n",
        ),
        "src/p/setup.cfg:2",
        "q",
        "setup.cfg is about 'q', package.xml about 'p'",
        "write name = p",
    ),
    "no setup.cfg": Case(
        python_package("p", setup_cfg=None),
        "src/p/setup.py",
        "",
        "without a setup.cfg the programs are installed in bin/, where ros2 run does not find them",
        "create setup.cfg: [develop] script_dir=$base/lib/p, [install] install_scripts=$base/lib/p",
    ),
    "setup.cfg without script_dir": Case(
        python_package("p", setup_cfg="[install]\ninstall_scripts=$base/lib/p\n"),
        "src/p/setup.cfg",
        "",
        f"[develop] has no script_dir: {NOT_FOUND}",
        "write [develop] script_dir=$base/lib/p",
    ),
    "a misspelt key in setup.cfg": Case(
        python_package(
            "p",
            setup_cfg="[develop]\nscript_dir=$base/lib/p\n[install]\ninstall_script=$base/lib/p\n",
        ),
        "src/p/setup.cfg:4",
        "install_script",
        f"[install] has no install_scripts: {NOT_FOUND}",
        "did you mean install_scripts?",
    ),
    "setup.cfg of another package": Case(
        python_package(
            "p",
            setup_cfg="[develop]\nscript_dir=$base/lib/q\n[install]\ninstall_scripts=$base/lib/p\n",
        ),
        "src/p/setup.cfg:2",
        "q",
        "script_dir must be $base/lib/p, so that ros2 run finds the programs",
        "write script_dir=$base/lib/p",
    ),
    "the programs of setup.cfg of another package": Case(
        python_package(
            "p",
            setup_cfg="[develop]\nscript_dir=$base/lib/p\n[install]\ninstall-scripts=$base/lib/q\n",
        ),
        "src/p/setup.cfg:4",
        "q",
        "install_scripts must be $base/lib/p, so that ros2 run finds the programs",
        "write install_scripts=$base/lib/p",
    ),
}
