"""Which body carries which in the mated stack.

A body hangs on another if every chain of attachments from A to it leads over that one.
"""

from drakesep.systems.model.separation import Separation


def carriers(separation: Separation) -> dict[str, str | None]:
    """Return what carries each body but A, the nearest of the bodies that it hangs on.

    None: A alone. Bodies come after what carries them.

    Args:
        separation: whose first A carries the stack.
    """
    everything = _reached(separation, without=None)
    hanging = {
        body.name: everything - _reached(separation, without=body.name) - {body.name}
        for body in separation.bodies
        if body.name != separation.A
    }
    below = {
        name: [other for other, above in hanging.items() if name in above]
        for name in hanging
    }
    in_order = sorted(hanging, key=lambda name: len(below[name]))
    return {
        name: max(below[name], key=lambda other: len(below[other]), default=None)
        for name in in_order
    }


def _reached(separation: Separation, without: str | None) -> set[str]:
    """Return the bodies that chains of attachments lead to from A."""
    reached, front = {separation.A}, [separation.A]
    while front:
        name = front.pop()
        for attachment in separation.attached_to(name):
            for end in (attachment.A, attachment.B):
                if end not in reached and end != without:
                    reached.add(end)
                    front.append(end)
    return reached
