"""Where two objects meet, and how deep."""

from __future__ import annotations

from .._arrays import Floats
from .._simdop import Body
from .models import BVHModel
from .objects import CollisionObject, relative
from .requests import Contact
from .shapes import Convex, TriangleP


def find_contacts(o1: CollisionObject, o2: CollisionObject, most: int) -> list[Contact]:
    """At least one contact of two objects that meet. Normals point from the first to the second."""
    if not any(isinstance(o._geometry, Convex) for o in (o1, o2)):
        return _contacts_of_primitives(o1, o2, most)
    if o1._is_mesh() or o2._is_mesh():
        return _contacts_of_triangles(o1, o2, most)
    return [_contact(o1, o2, *_penetration(o1, o2))]


def bare_contact(o1: CollisionObject, o2: CollisionObject) -> Contact:
    """A contact of two objects without its position and depth."""
    contact = Contact()
    contact.o1, contact.o2 = o1._geometry, o2._geometry
    contact.b1 = contact.b2 = -1
    return contact


def _contact(o1: CollisionObject, o2: CollisionObject, pos: Floats, normal: Floats, depth: float) -> Contact:
    contact = bare_contact(o1, o2)
    contact.pos, contact.normal, contact.penetration_depth = pos, normal, depth
    return contact


def _contacts_of_primitives(o1: CollisionObject, o2: CollisionObject, most: int) -> list[Contact]:
    found = o1._geometry._body().contacts(o2._geometry._body(), relative(o1, o2), limit=most)
    rotation, shift = o2._matrix[:3, :3], o2._matrix[:3, 3]
    contacts = []
    rows = zip(found.index_a, found.index_b, found.points, found.normals, found.depths, strict=True)
    for a, b, point, normal, depth in rows:
        contact = _contact(o1, o2, rotation @ point + shift, -(rotation @ normal), float(depth))
        contact.b1, contact.b2 = o1._triangle(a), o2._triangle(b)
        contacts.append(contact)
    return contacts


def _contacts_of_triangles(o1: CollisionObject, o2: CollisionObject, most: int) -> list[Contact]:
    """The contacts of a convex solid and the triangles of a mesh that reach into it."""
    is_first = o2._is_mesh()
    convex, mesh = (o1, o2) if is_first else (o2, o1)
    model = mesh._geometry
    assert isinstance(model, BVHModel)
    vertices, triangles = model._mesh()
    body, world = convex._geometry._body(), vertices @ mesh._matrix[:3, :3].T + mesh._matrix[:3, 3]
    inverse = relative(CollisionObject(model), convex)
    contacts: list[Contact] = []
    for index, corners in enumerate(world[triangles]):
        if len(contacts) == most:
            break
        if not Body.triangle(corners).collide(body, inverse):
            continue
        triangle = CollisionObject(TriangleP(*corners))
        pair = (convex, triangle) if is_first else (triangle, convex)
        contact = _contact(o1, o2, *_penetration(*pair))
        contact.b1, contact.b2 = o1._triangle(index), o2._triangle(index)
        contacts.append(contact)
    return contacts


def _penetration(o1: CollisionObject, o2: CollisionObject) -> tuple[Floats, Floats, float]:
    """The point, normal and depth of the contact of two convex sets."""
    found = o1._geometry._body().signed_distance(o2._geometry._body(), relative(o1, o2))
    depth = max(-float(found.lower), 0.0)
    rotation, shift = o2._matrix[:3, :3], o2._matrix[:3, 3]
    out, deepest = rotation @ found.normal, rotation @ found.point_a + shift
    return deepest + 0.5 * depth * out, -out, depth
