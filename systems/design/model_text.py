"""Model files without what does not bear on mass: looks, sensors, contact, actuators.

Drake's parser stops at what it does not know. What a model holds beside its bodies,
their mass and their places is left out before it is asked, by name; what might bear on
mass and is not known stays, or is refused here.
"""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from drakesep.systems.checks import InputError


_ROOTS = ("sdf", "robot", "mujoco", "mujocoinclude")
"""Of model files."""
_PLACE = {"pos", "quat", "axisangle", "xyaxes", "zaxis", "euler"}
_MJCF_GEOM = {
    *_PLACE,
    *("class", "type", "size", "fromto", "mass", "density", "mesh"),
    *("fitscale", "shellinertia"),
}
_ELEMENTS: Mapping[str, set[str]] = {
    "robot": {"link", "joint", "frame"},
    "link": {"inertial", "pose"},
    "sdf": {"world", "model"},
    "world": {"model", "include", "frame", "joint"},
    "model": {"model", "include", "frame", "joint", "link", "pose"},
    "include": {"uri", "name", "pose", "placement_frame"},
    "mujoco": {"compiler", "default", "asset", "worldbody"},
    "default": {"default", "geom", "mesh"},
    "asset": {"mesh"},
    "collision": {"pose", "geometry", "density"},
}
"""Of what is read: the elements within that are read too, where others are left out."""
_OF_JOINTS = {"dynamics", "calibration", "safety_controller", "mimic", "sensor"}
"""What URDF and SDF have in joints and axes, left out."""
_OF_BODIES = {"joint", "freejoint", "site", "camera", "light", "plugin"}
"""What MJCF has in bodies, left out: joints stand as they are drawn."""
_IN_BODIES = {"inertial", "geom", "body", "frame"}
_ATTRIBUTES: Mapping[str, set[str]] = {
    "body": {*_PLACE, "name", "childclass"},
    "frame": {*_PLACE, "name", "childclass"},
    "geom": _MJCF_GEOM,
}
"""Of elements of MJCF: those that are read, where others are left out."""
_OF_COMPILER = {"angle", "coordinate", "eulerseq", "inertiafromgeom", "meshdir"}
_NO_MATTER = {
    *("autolimits", "texturedir", "discardvisual", "usethread", "fusestatic"),
    *("convexhull", "strippath", "saveinertial", "alignfree", "assetdir"),
    *("balanceinertia", "conflict"),
}
"""Of the compiler of MJCF: what bears on mass and is read, and what does not."""


class ModelText(NamedTuple):
    """What a parser is to read."""

    text: str
    suffix: str
    """Of its format, for Drake: sdf, urdf or xml."""
    first: str
    """Name of the first body, where the parser may count another first; or empty."""


def bare_model(file: Path, name: str, folder: Path) -> ModelText | None:
    """Return a model's text without what does not bear on its mass.

    Args:
        file: SDF, URDF or MJCF.
        name: of the file, for messages.
        folder: for what an SDF includes.

    Returns:
        None if it is no XML, of which the parser has more to say.

    Raises:
        ValueError: what it includes is no model, or itself, or MJCF has bodies that
            cannot be read.
    """
    root = _tree(file, name, folder, ())
    if root is None:
        return None
    if root.tag == "mujoco":
        return _bare_mjcf(root, file, name)
    text = ElementTree.tostring(root, encoding="unicode")
    return ModelText(text, "urdf" if root.tag == "robot" else "sdf", "")


def _name(element: Element | None, file: Path, attribute: str = "name") -> None:
    """Give a model without a name that of its file."""
    if element is not None and not element.get(attribute):
        element.set(attribute, file.stem)


def _tree(
    file: Path, name: str, folder: Path, above: tuple[Path, ...]
) -> Element | None:
    """Return the tree of a file, with what it includes; None if it is no XML.

    Drake's parser leaves out without a word what is included and no model.
    """
    try:
        root = ElementTree.parse(file).getroot()
    except (OSError, ElementTree.ParseError) as error:
        if not above:
            return None
        raise InputError(
            f"{name}: include {file.name} must be a model, got: {error}"
        ) from error
    if above and root.tag not in _ROOTS:
        raise InputError(
            f"{name}: include {file.name} must be a model, got <{root.tag}>"
        )
    for parent in list(root.iter()):
        for place, include in enumerate(list(parent)):
            if include.tag != "include":
                continue
            got = _included(file, include, root.tag, name, folder, above)
            if got is not None:
                parent[place : place + 1] = list(got)
    if root.tag in ("robot", "sdf"):
        _name(root if root.tag == "robot" else root.find("model"), file)
        _keep(root)
    return root


def _included(
    file: Path,
    include: Element,
    kind: str,
    name: str,
    folder: Path,
    above: tuple[Path, ...],
) -> Element | None:
    """Return what takes the place of an include; of SDF, write it into the folder.

    An include is looked for beside the file that names it; MJCF's first beside the
    file that is not included by another.
    """
    uri = (include.get("file") or include.findtext("uri") or "").strip()
    uri = uri.removeprefix("file://")
    if "://" in uri:
        return None  # refused by the parser, which knows no packages
    folders = [file.parent]
    if kind.startswith("mujoco") and above:
        folders.insert(0, above[0].parent)  # as MuJoCo looks
    there = [path for home in folders if (path := home / uri).exists()]
    if not there:
        raise InputError(f"{name}: include {uri} must be a model, got no file")
    target = there[0] / "model.sdf" if there[0].is_dir() else there[0]
    target = target.resolve()
    if target in (*above, file.resolve()):
        raise InputError(f"{name}: must not include itself, got {target.name}")
    got = _tree(target, name, folder, (*above, file.resolve()))
    assert got is not None  # with one above
    if kind != "sdf":
        return got
    copy = folder / f"{len(list(folder.iterdir()))}_{target.name}"
    copy.write_text(ElementTree.tostring(got, encoding="unicode"), encoding="utf-8")
    for element in include.iter("uri"):
        element.text = str(copy)
    return None


def _drop(parent: Element, unwanted: Iterable[Element]) -> None:
    for element in list(unwanted):
        parent.remove(element)


def _keep(element: Element) -> None:
    """Leave out of an element of URDF or SDF what does not bear on mass."""
    wanted = _ELEMENTS.get(element.tag)
    inertial = element.find("inertial") if element.tag == "link" else None
    if inertial is not None and inertial.get("auto") in ("true", "1"):
        wanted = {*_ELEMENTS["link"], "collision"}  # SDF computes it from these
    if wanted is not None:
        _drop(element, [child for child in element if child.tag not in wanted])
    elif element.tag in ("joint", "axis", "axis2"):
        _drop(element, [child for child in element if child.tag in _OF_JOINTS])
    for child in element:
        _keep(child)


def _bare_mjcf(root: Element, file: Path, name: str) -> ModelText:
    _name(root, file, "model")
    _drop(root, [child for child in root if child.tag not in _ELEMENTS["mujoco"]])
    from_geoms = False
    for compiler in root.findall("compiler"):
        _bare_compiler(compiler, name)
        from_geoms |= compiler.get("inertiafromgeom") == "true"
    for tag in ("default", "asset"):
        for section in list(root.iter(tag)):
            wanted = _ELEMENTS[tag]
            _drop(section, [child for child in section if child.tag not in wanted])
    first = next(
        (body for world in root.findall("worldbody") for body in world.iter("body")),
        None,
    )
    _name(first, file)
    for world in root.findall("worldbody"):
        _bare_body(world, name, from_geoms, in_world=True)
    for geom in root.iter("geom"):
        _only(geom, "geom")
    _drop_weightless_meshes(root)
    _drop_unused_meshes(root)
    text = ElementTree.tostring(root, encoding="unicode")
    return ModelText(text, "xml", "" if first is None else first.get("name", ""))


def _only(element: Element, tag: str) -> None:
    """Leave attributes out that are not read."""
    for attribute in set(element.attrib) - _ATTRIBUTES[tag]:
        del element.attrib[attribute]


def _bare_compiler(compiler: Element, name: str) -> None:
    if "meshdir" not in compiler.attrib and "assetdir" in compiler.attrib:
        compiler.set("meshdir", compiler.attrib["assetdir"])
    for attribute in list(compiler.attrib):
        if attribute in _NO_MATTER:
            del compiler.attrib[attribute]
        elif attribute not in _OF_COMPILER:
            raise InputError(
                f"{name}: compiler must say nothing else of mass than "
                f"{', '.join(sorted(_OF_COMPILER))}, got {attribute}; give mass, CG "
                "and inertia in the case file"
            )
    _drop(compiler, list(compiler))


def _bare_body(body: Element, name: str, from_geoms: bool, *, in_world: bool) -> None:
    """Leave out of a body what does not bear on mass, and of those within.

    A frame is a body that weighs nothing.

    Args:
        body: or the world, or a frame.
        name: of the file.
        from_geoms: whether inertias are those of the geoms, whatever else is said.
        in_world: whether its geoms are the world's, which weighs nothing.
    """
    unknown = [c.tag for c in body if c.tag not in _IN_BODIES | _OF_BODIES]
    if unknown:
        raise InputError(
            f"{name}: bodies must be made of {', '.join(sorted(_IN_BODIES))}, got "
            f"{unknown[0]}; give mass, CG and inertia in the case file"
        )
    weighed = body.find("inertial") is not None and not from_geoms
    left_out = _OF_BODIES | ({"geom"} if in_world or weighed else set())
    _drop(body, [child for child in body if child.tag in left_out])
    for child in body:
        if child.tag in ("body", "frame"):
            _only(child, child.tag)
            held = in_world and child.tag == "frame"
            _bare_body(child, name, from_geoms, in_world=held)
            child.tag = "body"


_WEIGHING = "mass", "density"
"""Attributes of a geom of MJCF: what it weighs, the first before the second."""


def _drop_weightless_meshes(root: Element) -> None:
    """Leave geoms out that are drawn alone: meshes of no mass, which may be missing."""
    by_class: dict[str, dict[str, str]] = {"main": {}}
    for default in root.findall("default"):
        default.attrib.pop("class", None)  # whatever its name, it is of all geoms
        _weights_of_classes(default, by_class["main"], by_class)
    for world in root.findall("worldbody"):
        _drop_weightless_of_body(world, "main", by_class)


def _weights_of_classes(
    default: Element, above: Mapping[str, str], by_class: dict[str, dict[str, str]]
) -> None:
    """Find what geoms of a class, and of those within, weigh if they do not say it."""
    own = {key: g.attrib[key] for g in default.findall("geom") for key in g.attrib}
    stated = {**above, **{key: own[key] for key in _WEIGHING if key in own}}
    by_class.setdefault(default.get("class", "main"), {}).update(stated)
    for child in default.findall("default"):
        _weights_of_classes(child, stated, by_class)


def _drop_weightless_of_body(
    body: Element, kind: str, by_class: Mapping[str, Mapping[str, str]]
) -> None:
    kind = body.get("childclass", kind)
    for child in list(body):
        if child.tag == "body":
            _drop_weightless_of_body(child, kind, by_class)
        elif child.tag == "geom" and "mesh" in child.attrib:
            stated = {**by_class.get(child.get("class", kind), {}), **child.attrib}
            [*weighs] = [stated[key] for key in _WEIGHING if key in stated]
            if weighs and _is_zero(weighs[0]):
                body.remove(child)


def _is_zero(text: str) -> bool:
    try:
        return float(text) == 0.0
    except ValueError:
        return False  # for the parser to refuse


def _drop_unused_meshes(root: Element) -> None:
    """Leave meshes out that no body is weighed by: they may be missing."""
    used = {geom.get("mesh") for geom in root.iter("geom")}
    for asset in root.iter("asset"):
        _drop(asset, [m for m in asset if _mesh_name(m) not in used])


def _mesh_name(mesh: Element) -> str:
    return mesh.get("name") or Path(mesh.get("file", "")).stem
