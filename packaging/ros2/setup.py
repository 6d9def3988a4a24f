from setuptools import setup

NAME = "seatrial_ros"
setup(
    name=NAME,
    version="0.3.0",
    packages=[NAME],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/launch", ["launch/trial.launch.py"]),
        (f"share/{NAME}/config", ["config/two_thrusters.yaml"]),
    ],
    install_requires=["setuptools"],
    entry_points={"console_scripts": [f"trial = {NAME}.trial:main"]},
)
