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
}
