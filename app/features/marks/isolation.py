"""Process for an untrusted file. Arguments all|none FOLDER SEEN COMMAND …: runs a command with limits.

With `all` on Linux it runs in new namespaces if the system allows it: it sees only its own processes, has no
network, reads only the system's programs and libraries and SEEN (separated by os.pathsep), and writes only to
FOLDER, empty and in memory. All processes end with the first.
"""

import contextlib
import ctypes
import os
import signal
import sys
from collections.abc import Callable
from typing import Any, Final

PROCESSES: Final = 48
FILE: Final = 16 * 2**20
"""Largest file [bytes]."""
ROOM: Final = 64 * 2**20
"""Folder in memory [bytes]."""
DESCRIPTORS: Final = 64
"""Each may be a file in memory."""
SYSTEM: Final = (
    *("/bin", "/lib", "/lib32", "/lib64", "/sbin", "/usr", "/nix/store", "/gnu/store"),
    *(
        "/etc/alternatives",
        "/etc/ld.so.cache",
        "/etc/localtime",
        "/dev/null",
        "/dev/random",
        "/dev/urandom",
        "/dev/zero",
    ),
)
"""Folders that Python and its libraries may need."""

UNAVAILABLE: Final = 96
"""Exit code if the system does not permit it."""

_USER, _MOUNTS, _PROCESSES = 0x10000000, 0x00020000, 0x20000000
_NETWORK, _MESSAGES = 0x40000000, 0x08000000
"""`CLONE_NEW…` of <sched.h>."""
_PRIVATE, _BIND, _DETACH = 1 << 14 | 1 << 18, 1 << 14 | 1 << 12, 2
"""`MS_REC | MS_PRIVATE`, `MS_REC | MS_BIND` and `MNT_DETACH` of <sys/mount.h>."""
_SET_ATTRIBUTES: Final = 442
"""`mount_setattr`, the same number on every architecture."""
_RECURSIVE, _READ_ONLY, _HERE = 0x8000, 1, -100
"""`AT_RECURSIVE`, `MOUNT_ATTR_RDONLY`, `AT_FDCWD`."""
_DEATH_SIGNAL, _DUMPABLE, _ADOPTING, _NO_NEW_PRIVILEGES = 1, 4, 36, 38
"""<sys/prctl.h>"""


def main() -> None:
    """Run the command in the best available isolation; its name is the last argument."""
    wanted, folder, seen, *command = sys.argv[1:]
    limit_resources()
    levels: list[tuple[str, Callable[[], None]]] = [("none", lambda: None)]
    if sys.platform == "linux":
        _prctl(_DEATH_SIGNAL, signal.SIGKILL)
        # An orphaned process becomes a child of this one, where it is counted.
        _prctl(_ADOPTING, 1)
        if wanted == "all":
            full = ("full", lambda: _own_world(folder, seen.split(os.pathsep)))
            levels = [full, ("network", lambda: _enter(_USER | _NETWORK)), *levels]
    if os.name != "posix":
        os.chdir(folder)
        os.execv(command[0], [*command, "none"])
    for level, enter in levels:
        child = os.fork()
        if child == 0:
            try:
                enter()
                os.chdir(folder)
                if level != "none":
                    _prctl(_NO_NEW_PRIVILEGES, 1)
            except (OSError, AttributeError):
                os._exit(UNAVAILABLE)
            os.execv(command[0], [*command, level])
        code = _ended(child)
        if code != UNAVAILABLE:
            sys.exit(code)


def limit_resources() -> None:
    try:
        import resource
    except ImportError:
        return
    limits = {"RLIMIT_FSIZE": FILE, "RLIMIT_CORE": 0, "RLIMIT_NOFILE": DESCRIPTORS}
    for name, most in limits.items():
        with contextlib.suppress(OSError, ValueError):
            resource.setrlimit(getattr(resource, name), (most, most))
    os.nice(5)


def guard_memory() -> None:
    """Hide memory and descriptors from other processes of the same user."""
    if sys.platform == "linux":
        _prctl(_DUMPABLE, 0)


def _own_world(folder: str, seen: list[str]) -> None:
    """Enter all namespaces, with a new root; returns in its first process."""
    import resource

    _enter(_USER | _MOUNTS | _PROCESSES | _NETWORK | _MESSAGES)
    child = os.fork()
    if child:
        os._exit(_ended(child))
    _prctl(_DEATH_SIGNAL, signal.SIGKILL)
    _call("mount", None, b"/", None, ctypes.c_ulong(_PRIVATE), None)
    _mount(b"tmpfs", folder)
    for path in sorted({*SYSTEM, *seen}):
        _show(path, folder + path)
    for made in ("/proc", folder):
        os.makedirs(folder + made, exist_ok=True)
    read_only = (ctypes.c_uint64 * 4)(_READ_ONLY, 0, 0, 0)
    _call(
        "syscall",
        ctypes.c_long(_SET_ATTRIBUTES),
        _HERE,
        os.fsencode(folder),
        _RECURSIVE,
        read_only,
        ctypes.c_size_t(32),
    )
    _mount(b"tmpfs", folder + folder, f"size={ROOM}")
    _mount(b"proc", folder + "/proc")
    os.chdir(folder)
    # The old root covers the new one until it is detached.
    _call("pivot_root", b".", b".")
    _call("umount2", b".", _DETACH)
    with contextlib.suppress(OSError), open("/proc/sys/kernel/pid_max", "w", encoding="ascii") as file:
        # Since Linux 6.14 each of these namespaces has its own number; 301 is the least.
        file.write(str(300 + PROCESSES))
    # Of this user namespace. Linux does not count those of root, and before 5.14 it counts all of the user.
    resource.setrlimit(resource.RLIMIT_NPROC, (PROCESSES, PROCESSES))


def _mount(kind: bytes, place: str, options: str = "") -> None:
    _call("mount", kind, os.fsencode(place), kind, ctypes.c_ulong(0), options.encode())


def _show(path: str, place: str) -> None:
    """Bind a file or folder, if it exists; links at the top level stay links."""
    if not os.path.exists(path) or (os.path.exists(place) and os.path.samefile(path, place)):
        return
    os.makedirs(os.path.dirname(place), exist_ok=True)
    if os.path.islink(path) and path.count("/") == 1:
        os.symlink(os.readlink(path).lstrip("/"), place)
        return
    if os.path.isdir(path):
        os.makedirs(place, exist_ok=True)
    else:
        open(place, "ab").close()
    _call("mount", os.fsencode(path), os.fsencode(place), None, ctypes.c_ulong(_BIND), None)


def _enter(namespaces: int) -> None:
    """Enter new namespaces as the same user; root becomes another number, without rights after the next
    `exec`.
    """
    user, group = os.getuid(), os.getgid()
    _call("unshare", namespaces)
    for name, text in (
        ("setgroups", "deny"),
        ("uid_map", f"{user or 1000} {user} 1"),
        ("gid_map", f"{group or 1000} {group} 1"),
    ):
        with open(f"/proc/self/{name}", "w", encoding="ascii") as file:
            file.write(text)


def _ended(child: int) -> int:
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    return code if code >= 0 else 128 - code


def _prctl(option: int, value: int) -> None:
    _call("prctl", option, ctypes.c_ulong(value), ctypes.c_ulong(0), ctypes.c_ulong(0), ctypes.c_ulong(0))


def _call(name: str, *arguments: Any) -> None:
    """Raises `OSError`."""
    if getattr(ctypes.CDLL(None, use_errno=True), name)(*arguments) < 0:
        number = ctypes.get_errno()
        raise OSError(number, f"{name}: {os.strerror(number)}")
