# SPDX-License-Identifier: MIT
"""What pyproject.toml cannot say: packages are found, and those of mrts_codegen in a folder of another name."""

from setuptools import find_packages, setup

codegen = [f"mrts_codegen.{name}" for name in find_packages("codegen")]
setup(packages=[*find_packages(include=["mrts", "mrts.*"]), "mrts_codegen", *codegen])
