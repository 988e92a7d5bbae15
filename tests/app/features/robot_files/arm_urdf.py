"""A URDF file of an arm."""

AXES = "zyyzyz"
LENGTHS = (0.18, 0.14, 0.38, 0.20, 0.18, 0.10)


def arm_urdf(count: int = 6, kind: str = "revolute", more: str = "", shape: str = "") -> str:
    """An arm of cylinders and boxes; `kind` is the type of its third joint."""
    shape = shape or '<cylinder radius="0.05" length="{length}"/>'
    links, joints = (
        ['<link name="base"><collision><geometry><box size="0.2 0.2 0.04"/></geometry></collision></link>'],
        [],
    )
    for i, (axis, length) in enumerate(zip(AXES[:count], LENGTHS, strict=False), start=1):
        place = f'<origin xyz="0 0 {length / 2}"/><geometry>{shape.format(length=length)}</geometry>'
        links.append(f'<link name="l{i}"><visual>{place}</visual><collision>{place}</collision></link>')
        xyz = {"z": "0 0 1", "y": "0 1 0"}[axis]
        before = 0.04 if i == 1 else LENGTHS[i - 2]
        joints.append(
            f'<joint name="l{i}" type="{kind if i == 3 else "revolute"}"><parent link="{"base" if i == 1 else f"l{i - 1}"}"/>'
            f'<child link="l{i}"/><origin xyz="0 0 {before}"/><axis xyz="{xyz}"/>'
            '<limit lower="-2.7" upper="2.7" velocity="2" effort="1"/></joint>'
        )
    return f'<robot name="box arm">{"".join(links + joints)}{more}</robot>'
