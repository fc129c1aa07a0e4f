"""The bodies' parts in a plant's scene: to be seen, and to push where they touch."""

from typing import Any

import pydrake.geometry as drake
from pydrake.multibody.plant import ContactModel, CoulombFriction, MultibodyPlant

from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError
from drakesep.systems.geometry.convex_pieces import pieces_of
from drakesep.systems.geometry.illustration import colour_of, illustration_of
from drakesep.systems.model.part_pairs import part_pairs
from drakesep.systems.model.parts import Mesh
from drakesep.systems.model.separation import Separation


@typed
def register_illustration(plant: MultibodyPlant, separation: Separation) -> None:
    """Give the bodies of a plant the looks of their parts.

    Args:
        plant: source of a SceneGraph, not finalized, with bodies of their names.
        separation: whose bodies have parts.

    Raises:
        ValueError: a mesh is missing or empty.
    """
    for body in separation.bodies:
        link = plant.GetBodyByName(body.name)
        for part in body.parts:
            shape, X_BG = illustration_of(part)
            colour = colour_of(part, body, separation)
            plant.RegisterVisualGeometry(link, X_BG, shape, part.name, colour)


@typed
def register_contact(
    plant: MultibodyPlant, scene: drake.SceneGraph, separation: Separation
) -> dict[Any, str]:
    """Let parts of different bodies push each other where they touch.

    Parts are cut into the convex pieces of
    `drakesep.systems.geometry.convex_pieces`: Drake would take the hull of what is
    hollow. The plant's contact model becomes that of points. On a plant of one's own,
    `add_separation` then takes the separation without:
    ``dataclasses.replace(separation, recontact=None)``.

    Args:
        plant: continuous, source of the scene, not finalized, with bodies of their
            names.
        scene: of the plant.
        separation: with `Separation.recontact`.

    Returns:
        The part of each of Drake's geometries, by its id.

    Raises:
        ValueError: there is no recontact, a pair names no parts of two bodies, or a
            mesh cannot be read or is not convex.
    """
    contact = separation.recontact
    if contact is None:
        raise InputError("recontact: must be given, got none")
    without = part_pairs(separation, contact.without)
    properties = drake.ProximityProperties()
    drake.AddContactMaterial(
        # Of two alike in series, each is twice as stiff as both together.
        point_stiffness=2.0 * contact.stiffness,
        dissipation=contact.dissipation,
        friction=CoulombFriction(contact.friction, contact.friction),
        properties=properties,
    )
    plant.set_contact_model(ContactModel.kPoint)
    mine: dict[str, list[Any]] = {}
    for body in separation.bodies:
        link = plant.GetBodyByName(body.name)
        for part in body.parts:
            pieces = pieces_of(part)
            if isinstance(part.shape, Mesh) and len(pieces) > 1:
                # Drake's depth in a triangle is that of its plane's edges: no depth.
                raise InputError(
                    f"recontact: {part.name}: a mesh that pushes must be convex, "
                    "got one that is not; make it of boxes, cones and convex meshes"
                )
            mine[part.name] = [
                plant.RegisterCollisionGeometry(
                    link, piece.X_BS, piece.shape, f"{part.name}_{k}", properties
                )
                for k, piece in enumerate(pieces)
            ]
    filters = scene.collision_filter_manager()
    for pair in without:
        first, second = (drake.GeometrySet(mine[name]) for name in pair)
        filters.Apply(drake.CollisionFilterDeclaration().ExcludeBetween(first, second))
    return {geometry: name for name, pieces in mine.items() for geometry in pieces}
