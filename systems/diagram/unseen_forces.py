"""What acts on the bodies of somebody else's plant, and cannot be seen from outside.

Rigid joints follow from all else that acts on their bodies.
"""

from collections.abc import Iterator, Sequence

from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import DiagramBuilder

from drakesep.systems.checks import InputError
from drakesep.systems.vectors import Vector


def check_all_is_seen(
    builder: DiagramBuilder, plant: MultibodyPlant, bodies: Sequence[RigidBody]
) -> None:
    """Raise InputError if something acts on bodies that a separation cannot see.

    It sees spatial forces that are handed over as other_forces. Gravity that is the
    same for all bodies pulls at no joint.

    Args:
        builder: that holds the plant.
        plant: finalized.
        bodies: that rigid joints join.
    """
    for unseen in _unseen(builder, plant, bodies):
        raise InputError(
            f"{unseen}, of which rigid joints on these bodies must know; give their "
            "joints stiffness and damping, as propose_joint does"
        )


def all_is_seen(
    builder: DiagramBuilder, plant: MultibodyPlant, body: RigidBody
) -> bool:
    """Return whether nothing but gravity acts on a body that a separation cannot see.

    Args:
        builder: that holds the plant.
        plant: finalized.
        body: of the plant.
    """
    return not any(_unseen(builder, plant, [body]))


def gravity_on(plant: MultibodyPlant, body: RigidBody) -> Vector:
    """Return the plant's gravity on a body, in its world, m/s^2."""
    if not plant.is_gravity_enabled(body.model_instance()):
        return 0.0, 0.0, 0.0
    x, y, z = plant.gravity_field().gravity_vector().tolist()
    return x, y, z


def _unseen(
    builder: DiagramBuilder, plant: MultibodyPlant, bodies: Sequence[RigidBody]
) -> Iterator[str]:
    for body in bodies:
        if not body.is_floating_base_body():
            yield f"{body.name()}: must float, got a joint or weld of the plant"
        if plant.GetCollisionGeometriesForBody(body):
            yield f"{body.name()}: must have no collision geometry, got contact"
    indices = {int(body.index()) for body in bodies}
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        if int(joint.parent_body().index()) in indices:
            yield (
                f"{joint.parent_body().name()}: must carry no joint of the plant, got "
                f"{joint.name()!r}"
            )
    if plant.num_force_elements() > 1:  # the first is gravity
        yield (
            "plant must have no force elements, got "
            f"{plant.num_force_elements() - 1} beside gravity"
        )
    pulled = {plant.is_gravity_enabled(body.model_instance()) for body in bodies}
    if len(pulled) > 1 and plant.gravity_field().gravity_vector().any():
        yield "gravity must be on for all bodies or none, got it on for some"
    if builder.IsConnectedOrExported(plant.get_applied_generalized_force_input_port()):
        yield "plant's applied_generalized_force input port must be free, got it taken"
