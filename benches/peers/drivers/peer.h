// What the harness asks of a peer. A driver is one shared library that exports these.
#pragma once
#include <cstddef>
#include <cstdint>

// Row-major [R|t]: body A in the frame of body B.
using Rows = double[12];

extern "C" {
// Of the peer's package.
const char *peer_version();
// A body; the arrays need not outlive the call. A body can be A and B of a query at once.
void *peer_build(const double *vertices, size_t vertex_count, const uint32_t *triangles, size_t triangle_count);
void peer_free(void *body);
// Everything the peer keeps for a body, with vertices and indices; 0: it does not say.
size_t peer_bytes(const void *body);
// Do the bodies meet? First hit ends it.
bool peer_collide(void *a, void *b, const Rows &rows);
// How far apart they are, with nothing allowed for; 0 or less where they meet. With -DDISTANCES only: not every peer and volume has distances.
double peer_distance(void *a, void *b, const Rows &rows);

// Of peers with managers of many bodies:

struct Placed {
  void *body;
  Rows place;
};

// Solids, to be freed as a body: a box about the origin, and a convex one.
void *peer_box(const double *sides);
void *peer_convex(const double *vertices, size_t vertex_count, const uint32_t *triangles, size_t triangle_count);
// A robot's links, at first like this, among obstacles that stand still. The bodies outlive it. asked[i * link_count + j]: are links i and j asked
// against each other?
void *peer_scene(const Placed *links, size_t link_count, const bool *asked, const Placed *obstacles, size_t obstacle_count);
void peer_scene_free(void *scene);
// Do the links, placed like this, meet an obstacle or each other? First hit ends it.
bool peer_scene_collide(void *scene, const Rows *places);
}
