import platform

import numpy as np

from rfcompass.studies import versions


def test_the_line_names_what_decides_about_numbers():
    line = versions.software_versions()
    assert f"numpy {np.__version__}" in line
    assert platform.python_version() in line
    assert "\n" not in line


def test_a_package_that_is_not_installed_is_said_so():
    assert versions._version("no-such-package-here") == "uninstalled"
