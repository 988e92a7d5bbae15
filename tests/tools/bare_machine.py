"""Runs the README's commands on a bare machine: a minimal Debian in its own folder, entered by chroot.

It has Python, git and libgomp1, but no font, browser, compiler or cache. It needs root on Debian, and
installs mmdebstrap if that is missing. Python's standard library is enough to run it:

    python3 tests/tools/bare_machine.py                         the README's second command (the tests) on the last commit
    python3 tests/tools/bare_machine.py 'COMMAND'               another command there, after the README's installation
    python3 tests/tools/bare_machine.py --suite trixie          Debian 13 instead of Debian 12
    python3 tests/tools/bare_machine.py --with 'fonts-noto-core fonts-liberation'     with more packages
    python3 tests/tools/bare_machine.py --then 'COMMAND'        the tests, then a command
    python3 tests/tools/bare_machine.py --or-here …             without a bare machine, run in this checkout

The first use downloads the system (about two minutes) and keeps it in the temporary folder; each use begins
with a fresh copy.
"""

import argparse
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

ROOT = Path(__file__).parents[2]
KEYRING = Path("/usr/share/keyrings/debian-archive-keyring.gpg")
PACKAGES = ("python3", "python3-venv", "git", "ca-certificates", "procps", "libgomp1")
"""Packages in addition to Debian's essential ones; pinocchio needs libgomp1, see the README."""
UNABLE = 3
"""Exit code if no bare machine can be made or entered."""

_HOSTS = "127.0.0.1 localhost\n::1 localhost\n"
_PATH = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"
_HANDED_ON = re.compile(r"PIP_(?!FIND_LINKS).*|(http|https|no)_proxy|(HTTP|HTTPS|NO)_PROXY")
"""Names of environment variables that pip needs to reach its index."""
_ENTER = """
set -euo pipefail
mount -t proc proc "$0/proc"
for place in sys dev; do mount --rbind "/$place" "$0/$place"; done
exec chroot "$0" bash -euo pipefail -c "$1"
"""


def readme_commands(readme: str) -> list[str]:
    """Shell commands of the README, without their outer line breaks: start the page, run the tests, …"""
    return [
        block.strip() for block in re.findall(r"^```sh\n(.*?)^```$", readme, flags=re.MULTILINE | re.DOTALL)
    ]


def installation(command: str) -> str:
    """The installing part of a README command, without the program started at its end."""
    return command.rpartition(" && ")[0]


def reason_against() -> str:
    """Reason why this computer cannot make a bare machine; empty if it can."""
    if sys.platform != "linux" or not hasattr(os, "geteuid") or os.geteuid() != 0:
        return "it takes root on Linux"
    if shutil.which("mmdebstrap") is None and shutil.which("apt-get") is None:
        return "mmdebstrap is missing, and there is no apt-get to install it"
    if shutil.which("mmdebstrap") is None:
        for command in (
            ["apt-get", "update", "-qq"],
            ["apt-get", "install", "-y", "-qq", "--no-install-recommends", "mmdebstrap"],
        ):
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            if done.returncode != 0:
                return f"mmdebstrap cannot be installed ({(done.stderr or done.stdout).strip()[-200:]})"
    allowed = subprocess.run(
        [*_unshare(), "mount", "-t", "proc", "proc", "/proc"], capture_output=True, text=True, check=False
    )
    return (
        ""
        if allowed.returncode == 0
        else f"namespaces and mounts are not allowed here ({allowed.stderr.strip()[-200:]})"
    )


def system_archive(suite: str) -> Path:
    """Archive of the minimal system, downloaded at the first use.

    Args:
        suite: code name of a Debian release.

    Raises:
        subprocess.CalledProcessError: the package archive cannot be reached, or lacks the release.
    """
    archive = Path(tempfile.gettempdir()) / f"duet-bare-machine-{suite}.tar"
    if not archive.exists():
        sites = subprocess.run(
            ["apt-get", "indextargets", "--format", "$(SITE)", "Identifier: Packages", "Origin: Debian"],
            capture_output=True,
            text=True,
            check=False,
        ).stdout.split()
        site = next((site for site in sites if "security" not in site), "http://deb.debian.org/debian")
        part = archive.with_suffix(".part")
        source = f"deb [signed-by={KEYRING}] {site} {suite} main"
        options = ["--quiet", "--format=tar", "--variant=minbase", f"--include={','.join(PACKAGES)}"]
        subprocess.run(["mmdebstrap", *options, suite, str(part), source], check=True)
        part.rename(archive)
    return archive


def run_there(command: str, suite: str, packages: Sequence[str], checkout: Path) -> int:
    """Run a command in a clone of the last commit on a fresh bare machine; return its exit code.

    Its processes and mounts have their own namespaces and end with the command.

    Args:
        command: for bash, in the clone's folder.
        packages: Debian packages in addition to `PACKAGES`.
    """
    if packages:
        command = f"apt-get update -qq && apt-get install -y -qq --no-install-recommends {' '.join(packages)} >/dev/null && {command}"
    root = Path(tempfile.mkdtemp(prefix="duet-bare-"))
    # SIGTERM removes it, too.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    try:
        subprocess.run(["tar", "-C", root, "-xf", system_archive(suite)], check=True)
        shutil.copy("/etc/resolv.conf", root / "etc")
        (root / "etc" / "hosts").write_text(_HOSTS, encoding="ascii")
        # Certificates and pip settings of this computer, to reach the package index.
        subprocess.run(
            ["cp", "-rT", "--remove-destination", "/etc/ssl/certs", root / "etc" / "ssl" / "certs"],
            check=True,
        )
        if Path("/etc/pip.conf").exists():
            shutil.copy("/etc/pip.conf", root / "etc")
        subprocess.run(["git", "clone", "-q", "--no-hardlinks", checkout, root / "root" / "duet"], check=True)
        print(f"+ {command}", flush=True)
        inside = [*_unshare(), "bash", "-c", _ENTER, root, f"cd /root/duet; {command}"]
        environment = {"HOME": "/root", "PATH": _PATH, "LANG": "C.UTF-8", **handed_on(os.environ)}
        done = subprocess.run(inside, env=environment, stdin=subprocess.DEVNULL, check=False)
        pictures = root / "root" / "duet" / ".artifacts"
        if pictures.exists():
            shutil.copytree(pictures, checkout / ".artifacts", dirs_exist_ok=True)
        return done.returncode
    finally:
        shutil.rmtree(root, ignore_errors=True)


def _unshare() -> list[str]:
    return ["unshare", "--mount", "--pid", "--ipc", "--fork", "--kill-child", "--propagation", "private"]


def handed_on(environment: Mapping[str, str]) -> dict[str, str]:
    """This computer's variables for pip's access to its index."""
    return {name: value for name, value in environment.items() if _HANDED_ON.fullmatch(name)}


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description="Run the README's commands on a bare machine.")
    parser.add_argument(
        "command", nargs="?", help="what to run after the README's installation; default: its tests"
    )
    parser.add_argument("--suite", default="bookworm", help="Debian release")
    parser.add_argument("--with", dest="packages", default="", help="further Debian packages")
    parser.add_argument("--then", default="", help="what to run after that")
    parser.add_argument(
        "--or-here", action="store_true", help="run in this checkout if no bare machine can be had"
    )
    chosen = parser.parse_args(arguments)
    command = readme_commands((ROOT / "README.md").read_text(encoding="utf-8"))[1]
    if chosen.command is not None:
        command = f"{installation(command)} && {chosen.command}"
    if chosen.then:
        # In a && list bash only stops at a failure of the last part.
        command += f" && {{\n{chosen.then}\n}}"
    reason = reason_against()
    if not reason:
        return run_there(command, chosen.suite, chosen.packages.split(), ROOT)
    print(f"No bare machine here: {reason}.", file=sys.stderr)
    if not chosen.or_here:
        return UNABLE
    print(f"+ {command}", flush=True)
    return subprocess.run(["bash", "-euo", "pipefail", "-c", command], cwd=ROOT, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
