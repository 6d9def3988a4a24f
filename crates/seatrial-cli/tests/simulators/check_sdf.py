"""Checks an SDF file: check_sdf.py FILE.sdf.

The rules are those of SDFormat 1.9 for the elements that the export may write, from sdformat's `sdf/1.9/{root,model,link,inertial,plugin}.sdf`,
and the names that sdformat's `src/Utils.cc` and `src/parser.cc` refuse.
"""

import math
import sys
import xml.etree.ElementTree as ElementTree

ONE, OPTIONAL, ANY = (1, 1), (0, 1), (0, math.inf)
# Of each element: the attributes that it must have, those that it may have, and how often each child may stand in it.
RULES = {
    "sdf": (["version"], [], {"world": ANY, "model": OPTIONAL, "actor": OPTIONAL, "light": OPTIONAL}),
    "model": (
        ["name"],
        ["canonical_link", "placement_frame"],
        {
            "static": OPTIONAL, "self_collide": OPTIONAL, "allow_auto_disable": OPTIONAL, "enable_wind": OPTIONAL, "pose": OPTIONAL,
            "frame": ANY, "link": ANY, "joint": ANY, "plugin": ANY, "gripper": ANY, "include": ANY, "model": ANY,
        },
    ),
    "link": (
        ["name"],
        [],
        {
            "gravity": OPTIONAL, "enable_wind": OPTIONAL, "self_collide": OPTIONAL, "kinematic": OPTIONAL, "must_be_base_link": OPTIONAL,
            "velocity_decay": OPTIONAL, "pose": OPTIONAL, "inertial": OPTIONAL, "collision": ANY, "visual": ANY, "sensor": ANY,
            "projector": ANY, "audio_sink": ANY, "audio_source": ANY, "battery": ANY, "light": ANY, "particle_emitter": ANY,
        },
    ),
    "inertial": ([], [], {"mass": OPTIONAL, "pose": OPTIONAL, "inertia": OPTIONAL}),
    "inertia": ([], [], {name: ONE for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")}),
}
NUMBERS = {"mass", "ixx", "ixy", "ixz", "iyy", "iyz", "izz"}
# Of gz-sim's Hydrodynamics::Configure: its own parameters, and derivatives xU, xUU, xUabsU, xUV and so on.
OWN = {"link_name", "disable_added_mass", "disable_coriolis"}
VELOCITIES = "UVWPQR"


def is_reserved(name):
    return not name or name == "world" or "::" in name or (len(name) >= 4 and name[:2] == name[-2:] == "__")


def is_derivative(name):
    force, *by = name.replace("abs", "")
    return force in "xyzkmn" and 1 <= len(by) <= 2 and all(velocity in VELOCITIES for velocity in by)


def check(element):
    required, optional, children = RULES[element.tag]
    for name in required:
        assert name in element.attrib, f"{element.tag}: attribute {name} is missing"
    for name in element.attrib:
        assert name in required + optional, f"{element.tag}: attribute {name}"
    assert not is_reserved(element.get("name", "-")), f"{element.tag}: name {element.get('name')!r}"
    tags = [child.tag for child in element]
    assert set(tags) <= set(children), f"{element.tag}: {tags}"
    for tag, (least, most) in children.items():
        assert least <= tags.count(tag) <= most, f"{element.tag}: {tag} {tags.count(tag)} times"
    for child in element:
        if child.tag in NUMBERS:
            assert math.isfinite(float(child.text)), child.tag
        elif child.tag == "plugin":
            check_hydrodynamics(child, element)
        else:
            check(child)


def check_hydrodynamics(plugin, model):
    assert {"filename", "name"} <= set(plugin.attrib)
    assert plugin.findtext("link_name") in [link.get("name") for link in model.findall("link")]
    for child in plugin:
        assert child.tag in OWN or is_derivative(child.tag), child.tag
        if child.tag not in OWN:
            assert math.isfinite(float(child.text)), child.tag


root = ElementTree.parse(sys.argv[1]).getroot()
assert root.tag == "sdf" and root.get("version") == "1.9"
check(root)
inertia = {child.tag: float(child.text) for child in root.find("model/link/inertial/inertia")}
# sdformat refuses a mass matrix whose principal moments do not satisfy the triangle inequality.
moments = sorted(inertia[name] for name in ("ixx", "iyy", "izz"))
assert 0.0 < moments[0] and moments[2] <= moments[0] + moments[1]
