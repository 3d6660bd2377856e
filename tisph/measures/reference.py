"""The reference solution at the particles of a snapshot, beside what they have."""

from dataclasses import replace


def with_reference(scene, snapshot, fields=None):
    """Return ``snapshot`` with its ``reference``: arrays (particles,) of all fields that the scene has one of.

    Of these only ``fields``, where they are given and the snapshot has no reference yet.
    """
    if snapshot.reference is not None:
        return snapshot
    names = scene.fields if fields is None else fields
    return replace(snapshot, reference={name: scene.exact(name, snapshot.x, snapshot.y, snapshot.t) for name in names})
