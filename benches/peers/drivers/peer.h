// The interface of a peer. A driver is a shared library that exports these functions.
#pragma once
#include <cstddef>
#include <cstdint>

// Row-major [R|t]: body A in the frame of body B.
using Rows = double[12];

extern "C" {
// The version of the peer's package.
const char *peer_version();
// A body; the arrays need not outlive the call. A body can be A and B of a query at once.
void *peer_build(const double *vertices, size_t vertex_count, const uint32_t *triangles, size_t triangle_count);
void peer_free(void *body);
// Everything the peer stores for a body, including vertices and indices; 0 if unknown.
size_t peer_bytes(const void *body);
// Whether the bodies meet; ends at the first hit.
bool peer_collide(void *a, void *b, const Rows &rows);
// The distance, without tolerance; 0 or less where they meet. With -DDISTANCES only: not every peer and volume has
// distances.
double peer_distance(void *a, void *b, const Rows &rows);

// For peers with managers of many bodies:

struct Placed {
  void *body;
  Rows place;
};

// Solids, to be freed as bodies: a box about the origin, and a convex one.
void *peer_box(const double *sides);
void *peer_convex(const double *vertices, size_t vertex_count, const uint32_t *triangles, size_t triangle_count);
// A robot's links, initially at these poses, among fixed obstacles. The bodies outlive it. asked[i * link_count + j]:
// whether links i and j are tested against each other.
void *peer_scene(const Placed *links, size_t link_count, const bool *asked, const Placed *obstacles,
                 size_t obstacle_count);
void peer_scene_free(void *scene);
// Whether the links, at these poses, meet an obstacle or each other; ends at the first hit.
bool peer_scene_collide(void *scene, const Rows *places);

// For peers with analytic convex shapes:

// About the origin, with axes along z. A half-space is below z = 0.
enum Kind { SPHERE, CAPSULE, CUBOID, CYLINDER, CONE, HALF_SPACE };

struct Solid {
  Kind kind;
  // The side lengths of a cuboid; otherwise the radius and the height, for a capsule that of its middle part.
  double size[3];
};

// A moving and a fixed solid.
void *peer_pair(const Solid *a, const Solid *b);
void peer_pair_free(void *pair);
bool peer_pair_collide(void *pair, const Rows &rows);
// The distance, 0 or less where they meet, and the closest points of A and of B, both in B's frame. NaN if the peer fails
// at this pose, and -infinity if it has no distance for such a pair.
double peer_pair_distance(void *pair, const Rows &rows, double *points);
}
