"""Where the C++ library lies that the package carries: headers, and what `find_package(cogging)` reads."""

from __future__ import annotations

import importlib.util
from pathlib import Path

from cogging.files import InputError

__all__ = ["get_cmake_dir", "get_include"]

#: Of the source tree, where there is no installed copy: what stands beside `python/cogging`.
SOURCES = Path(__file__).resolve().parents[2] / "cpp"


def get_include() -> str:
    """The folder for the compiler's `-I`: it holds `cogging/control/pid.hpp` and all other headers of the core.

    Of a package that is used from its source tree, uninstalled or editable, the folder `cpp` there.

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
    """The folder with `coggingConfig.cmake`, for `cmake -Dcogging_DIR=...`.

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
    """Where something stands below the package, if it is there at all."""
    # Of an editable installation the package has two folders: the sources and what was built.
    package = importlib.util.find_spec("cogging")
    assert package is not None
    return [Path(folder) / place for folder in package.submodule_search_locations or ()]
