"""The bodies' parts in a plant's scene: to be seen, and to push where they touch."""

from typing import Any

import pydrake.geometry as drake
from pydrake.multibody.plant import ContactModel, MultibodyPlant

from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError
from drakesep.systems.diagram.pushing_pieces import (
    properties_of,
    pushing_pieces,
    smallest_area,
)
from drakesep.systems.geometry.colours import colour_of
from drakesep.systems.geometry.illustration import illustration_of
from drakesep.systems.model.part_pairs import part_pairs
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
    hollow. The plant's contact model becomes the hydroelastic one, with points for what
    has no faces. On a plant of one's own, `add_separation` then takes the separation
    without: ``dataclasses.replace(separation, recontact=None)``.

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
    plant.set_contact_model(ContactModel.kHydroelasticWithFallback)
    cut = pushing_pieces(separation)
    face_stiffness = contact.face_stiffness or contact.stiffness / smallest_area(cut)
    mine: dict[str, list[Any]] = {}
    for body in separation.bodies:
        link = plant.GetBodyByName(body.name)
        for part in body.parts:
            mine[part.name] = [
                plant.RegisterCollisionGeometry(
                    link,
                    piece.X_BS,
                    piece.shape,
                    f"{part.name}_{k}",
                    properties_of(piece, contact, face_stiffness),
                )
                for k, piece in enumerate(cut[part])
            ]
    filters = scene.collision_filter_manager()
    for pair in without:
        first, second = (drake.GeometrySet(mine[name]) for name in pair)
        filters.Apply(drake.CollisionFilterDeclaration().ExcludeBetween(first, second))
    return {geometry: name for name, pieces in mine.items() for geometry in pieces}
