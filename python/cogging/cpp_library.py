"""Paths of the C++ library in the package: headers, and the CMake package for `find_package(cogging)`."""

from __future__ import annotations

import importlib.util
from pathlib import Path

from cogging.files import InputError

__all__ = ["get_cmake_dir", "get_include"]

#: The core in a source tree, for a package that is not installed.
SOURCES = Path(__file__).resolve().parents[2] / "cpp"


def get_include() -> str:
    """Return the folder for the compiler's `-I`, which holds `cogging/control/pid.hpp` and all headers of the core.

    In a source tree, uninstalled or editable, that is the folder `cpp`.

    Returns:
        The path.

    Raises:
        InputError: the headers are neither in the package nor beside it.

    Example:
        >>> import pathlib
        >>> (pathlib.Path(cogging.get_include()) / "cogging" / "control" / "pid.hpp").is_file()
        True
    """
    for folder in (*installed("include"), SOURCES):
        if (folder / "cogging" / "require.hpp").is_file():
            return str(folder)
    raise InputError(f"{SOURCES.parent}: must hold the headers of the core, got a package without cogging/include")


def get_cmake_dir() -> str:
    """Return the folder with `coggingConfig.cmake`, for `cmake -Dcogging_DIR=...`.

    Returns:
        The path.

    Raises:
        InputError: the package is used from its source tree, where nothing is installed.

    Example:
        >>> print(cogging.get_cmake_dir())  # doctest: +SKIP
        /usr/lib/python3/site-packages/cogging/cmake
    """
    for folder in installed("share/cmake/cogging"):
        if (folder / "coggingConfig.cmake").is_file():
            return str(folder)
    raise InputError(
        f"{Path(__file__).parent}: must be an installed package (pip install .) to have a CMake package, got a source "
        f"tree; add_subdirectory({SOURCES.parent}) does without"
    )


def installed(place: str) -> list[Path]:
    """Return the paths that a place below the package may have."""
    # An editable installation has two folders: the sources and the build.
    package = importlib.util.find_spec("cogging")
    assert package is not None
    return [Path(folder) / place for folder in package.submodule_search_locations or ()]
