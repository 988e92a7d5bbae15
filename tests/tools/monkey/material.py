"""What a visitor who does anything at all has at hand: keys, texts, links, files, and sizes of the window."""

from __future__ import annotations

import random
from typing import Final
from urllib.parse import quote

SCRIPT: Final = "<img src=x onerror=alert(1)>"
KEYS: Final = (*" .[]RAVLG12345NBCHYX?", "ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "PageUp", "Escape", "Tab", "Enter")
TEXTS: Final = ("", SCRIPT, "\u202e", "é" * 300, "0", "-1", "1e999", "NaN", "0.12", "99999999", "12,5")
SIZES: Final = ((1440, 900), (1024, 768), (800, 600), (390, 844))
LINKS: Final = (
    *("", "a" * 3000, f"q={quote(SCRIPT)}", "lesson=1", "lesson=3&step=2", "lesson=10", "lesson=99", "lesson=%3Cb%3E&step=-1"),
    *("step=2", "scene=imitation&ghost=frozen", "scene=nowhere", "rig=table&law=unprotected&dm=0.1&n=10", "dm=NaN&n=1e999&v="),
    *("%00%ff=%fe", "dm=0.1&dm=0.2", "lang=de", "lang=xx", "robot=panda&scene=solo", "resume=../../etc", "window=0x0"),
    "whatif=1&plot=speeds",
)
RUBBISH: Final = (
    ("empty.duet", b""),
    ("noise.duet", bytes(random.Random(0).randbytes(3000))),
    ("noise.bvh", b"HIERARCHY\nROOT Hips\n{\n OFFSET 0 0 nan\n"),
    ("half.zst", b"\x28\xb5\x2f\xfd" + bytes(range(50))),
    ("a.csv", b"t,x,y,z\n0,1e308,nan,x\n"),
    ("\N{PILE OF POO}.json", b'{"version": 1e999, "inputs": [[]]}' * 50),
)
