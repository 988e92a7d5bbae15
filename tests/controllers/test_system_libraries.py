"""A missing system library: recognised in the loader's message, and reported with its package."""

import importlib
import pickle
import sys
from pathlib import Path

import daqp
import pytest

from controllers.system_libraries import (
    PACKAGES,
    MissingLibrary,
    missing_library,
    naming_missing_library,
    remedy,
)

NODE = "/x/driver/node: error while loading shared libraries: libatomic.so.1: cannot open shared object file: No such file"


def needing(library: bytes, folder: Path) -> str:
    """Name of a module in `folder` with a library that the system's loader does not find."""
    assert daqp.__file__ is not None
    content = Path(daqp.__file__).read_bytes()
    assert len(library) <= len(b"libc.so.6") and content.count(b"\0libc.so.6\0") == 1
    (folder / "needy.so").write_bytes(
        content.replace(b"\0libc.so.6\0", b"\0" + library.ljust(9, b"\0") + b"\0")
    )
    return "needy"


@pytest.mark.skipif(sys.platform != "linux", reason="another loader, with other words")
def test_a_missing_library_of_a_module_is_reported_in_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(MissingLibrary) as caught, naming_missing_library():
        importlib.import_module(needing(b"libq.so.7", tmp_path))
    assert caught.value.library == "libq.so.7"
    assert str(caught.value) == remedy("libq.so.7", "needy") and "apt-file search libq.so.7" in remedy(
        "libq.so.7", "needy"
    )
    again = pickle.loads(pickle.dumps(caught.value))
    assert (str(again), again.library) == (str(caught.value), "libq.so.7")


def test_the_library_is_found_in_messages_of_python_node_and_a_wrapper() -> None:
    for library, package in PACKAGES.items():
        assert (
            missing_library(f"{library}: cannot open shared object file: No such file or directory")
            == library
        )
        assert remedy(library, "pinocchio").endswith(f"apt install {package}.")
    assert missing_library(NODE) == "libatomic.so.1"
    with (
        pytest.raises(MissingLibrary, match=r"libgomp\.so\.1.*apt install libgomp1"),
        naming_missing_library(),
    ):
        try:
            raise ImportError("libgomp.so.1: cannot open shared object file: No such file or directory")
        except ImportError as error:
            raise ImportError("the package cannot be used") from error


def test_the_message_names_the_package_that_needs_the_library() -> None:
    inside = "/x/site-packages/cmeel.prefix/lib/python3.11/site-packages/pinocchio/pinocchio_pywrap_default.cpython-311.so"
    said = "libgomp.so.1: cannot open shared object file: No such file or directory"
    for error, package in (
        (ImportError(said, name="pinocchio_pywrap_default", path=inside), "pinocchio"),
        (ImportError(said, name="cv2.cv2", path=None), "cv2"),
        (ImportError(said), "Python"),
        (OSError(said), "Python"),
    ):
        with pytest.raises(MissingLibrary, match=f"^{package} needs"), naming_missing_library():
            raise error


@pytest.mark.parametrize(
    "error",
    [
        ModuleNotFoundError("No module named 'cv2'", name="cv2"),
        ImportError("Numba needs NumPy 2.4 or less. Got NumPy 2.5."),
        FileNotFoundError(2, "No such file or directory", "robot.urdf"),
        # A package's own file: no system package has it.
        OSError(
            "/x/site-packages/own.libs/libown.so.1: cannot open shared object file: No such file or directory"
        ),
        ValueError("libgomp.so.1: cannot open shared object file"),
    ],
    ids=lambda error: str(error)[:20],
)
def test_every_other_error_passes_unchanged(error: Exception) -> None:
    with pytest.raises(type(error)) as caught, naming_missing_library():
        raise error
    assert caught.value is error
