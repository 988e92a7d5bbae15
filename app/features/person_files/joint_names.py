"""Names of a person's joints in various programs."""

import re
from collections.abc import Iterator
from typing import Final, NamedTuple

from scenes.settings import ArmName


class Convention(NamedTuple):
    """Blank-separated names of the joints where parts begin: lower case, without side, digits, signs, "bend"
    and "twist".
    """

    thigh: str
    collar: str
    upper_arm: str
    forearm: str
    hand: str


CONVENTIONS: Final = {
    "Mixamo, MotionBuilder, Rokoko, Perception Neuron": Convention(
        "upleg", "shoulder", "arm", "forearm", "hand"
    ),
    "Xsens MVN, Bandai Namco": Convention("upperleg", "shoulder", "upperarm", "forearm lowerarm", "hand"),
    "Xsens MVN BVH, SMPL, Second Life Bento, Kinect": Convention(
        "hip", "collar", "shoulder", "elbow", "wrist"
    ),
    "OptiTrack Motive": Convention("thigh", "shoulder", "uarm", "farm", "hand"),
    "Poser, Daz, Second Life": Convention("thigh", "collar", "shldr", "forearm", "hand"),
    "Daz Genesis 9, Reallusion, Blender Rigify": Convention(
        "thigh", "shoulder clavicle", "upperarm", "forearm", "hand"
    ),
    "Unreal, VRM, MakeHuman": Convention(
        "thigh upperleg", "clavicle shoulder", "upperarm", "lowerarm", "hand wrist"
    ),
    "3ds Max Biped": Convention("thigh", "clavicle", "upperarm", "forearm", "hand"),
    "Character Studio": Convention("hip", "collar", "uparm", "lowarm", "hand"),
    "CMU, Acclaim, Vicon": Convention("femur hipjoint", "clavicle", "humerus", "radius", "wrist hand"),
    "Advanced Skeleton": Convention("hip", "scapula", "shoulder", "elbow", "wrist"),
    "others": Convention("leg", "collarbone shoulderblade", "upperarm", "foarm", "palm"),
}
"""A word such as "shoulder" may mean a collar or an upper arm."""

HIPS: Final = ("hips", "hip", "pelvis", "root", "lowerback", "spine")
"""Names of the middle of the hips; the first one found counts."""


def _all(field: str) -> frozenset[str]:
    return frozenset(name for one in CONVENTIONS.values() for name in getattr(one, field).split())


THIGHS, ELBOWS, WRISTS = _all("thigh"), _all("forearm"), _all("hand")

COLLARS: Final = _all("collar") - _all("upper_arm")

SHOULDERS: Final = _all("collar") & _all("upper_arm")
"""Names of both a collar and an upper arm."""

UPPER_ARMS: Final = (_all("upper_arm") - SHOULDERS - {"arm"}, frozenset({"arm"}))
"""Names of upper arms alone; "arm" is last, as it may name the whole arm."""

ELBOWS_BELOW_SHOULDERS: Final = frozenset(
    name
    for one in CONVENTIONS.values()
    if SHOULDERS & set(one.upper_arm.split())
    for name in one.forearm.split()
)
"""Names of elbows in conventions that call an upper arm a shoulder."""

_PARTS: Final = frozenset().union(THIGHS, ELBOWS, WRISTS, COLLARS, SHOULDERS, *UPPER_ARMS)

_SIDES: Final[dict[str, ArmName]] = {"left": "left", "l": "left", "right": "right", "r": "right"}

_DECORATION: Final = frozenset(
    {
        "bip",
        "biped",
        "bone",
        "b",
        "def",
        "org",
        "mch",
        "j",
        "jnt",
        "joint",
        "mixamorig",
        "rig",
        "character",
        "skel",
        "bend",
    }
)

_WORD: Final = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
_TWIST: Final = re.compile(r"twist|roll", re.IGNORECASE)


def is_twist(name: str) -> bool:
    """True for joints that only turn a part about its own axis, such as lForearmTwist or LeftArmRoll."""
    return _TWIST.search(name) is not None


def joint_part(name: str) -> tuple[ArmName | None, str]:
    """Side and part of a joint, in lower case. A twist has the part that it turns; an unknown part is the
    rest.
    """
    words = [w.lower() for w in _WORD.findall(name.rsplit(":", 1)[-1])]
    words = [w for w in words if w not in _DECORATION] or words
    for i, word in enumerate(words):
        if word in _SIDES:
            rest = words[i + 1 :] or words[:i]
            return _SIDES[word], next((stem for stem in _stems(rest) if stem in _PARTS), "".join(rest))
    for stem in _stems(words):
        for word, side in _SIDES.items():
            for part in (stem.removeprefix(word), stem.removesuffix(word)):
                if part != stem and part in _PARTS:
                    return side, part
    return None, "".join(words)


def _stems(words: list[str]) -> Iterator[str]:
    """Name without twist and bend: whole, then without its first words."""
    for i in range(len(words)):
        yield _TWIST.split("".join(words[i:]))[0].removesuffix("bend")
