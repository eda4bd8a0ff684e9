"""A package of ROS 2 around generated C: its node, description and build file."""

from pathlib import Path

from observers.embedded.codegen import source_texts
from observers.embedded.generated_files import write_generated
from observers.embedded.jinja_templates import render
from observers.embedded.scalar_type import SINGLE, Real
from observers.protocol import FunctionObserver


def generate_ros2(
    observer: FunctionObserver, folder: str | Path, real: Real = SINGLE, *, name: str = "brushgrip"
) -> list[Path]:
    """Write an observer as a package of ROS 2, to be built by colcon.

    The node takes the joint's position [rad], velocity [rad/s] and effort [N m] from `joint_states`, the
    load [N] from `load` or from a parameter; a message is a sample. It publishes `~/estimate` in the
    order of `ESTIMATE`, and `~/reset` starts the observer anew. The name is that of package, executable
    and node; numbers in messages are double. Arguments, the files returned and errors are as for
    `observers.embedded.generate`.
    """
    texts, terms = source_texts(observer, real, name)
    kept = {file: texts[file] for file in (f"{name}.c", f"{name}.h", f"{name}.hpp", f"{name}.json")}
    templates = {
        f"{name}_node.cpp": "ros2_node.cpp", "package.xml": "ros2_package.xml",
        "CMakeLists.txt": "ros2_CMakeLists.txt",
    }  # fmt: skip
    files = kept | {file: render(template, terms) for file, template in templates.items()}
    return write_generated(folder, files)
