"""Begins the panel's process: `/usr/bin/python3 -I gui_boot.py OPTIONS`.

The distribution's Python has GTK and a NumPy of its own; this project's environment has another NumPy and no GTK. So
only the package `target_nav` is made known to it, by its place, and no folder of the environment comes on the path.
"""

import importlib.util
import sys
from pathlib import Path


def main() -> None:
    package = Path(__file__).resolve().parent.parent
    spec = importlib.util.spec_from_file_location(
        package.name, package / "__init__.py", submodule_search_locations=[str(package)]
    )
    if spec is None or spec.loader is None:
        sys.exit(f"{package} is no package of target_nav")
    module = importlib.util.module_from_spec(spec)
    sys.modules[package.name] = module
    spec.loader.exec_module(module)
    from target_nav.app.gui_main import main as panel

    panel()


if __name__ == "__main__":
    main()
