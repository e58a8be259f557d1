from glob import glob

from setuptools import setup

PACKAGE = "fleet_nodes"

setup(
    name=PACKAGE,
    version="0.1.0",
    packages=[PACKAGE],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        (f"share/{PACKAGE}/launch", sorted(glob("launch/*.*"))),
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    description="A dispatcher, robots and a monitor that use fleet_interfaces",
    license="MIT",
    entry_points={
        "console_scripts": [
            f"{node} = {PACKAGE}.{node}:main" for node in ("dispatcher", "monitor", "robot")
        ],
    },
)
