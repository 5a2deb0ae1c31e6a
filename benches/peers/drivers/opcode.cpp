// OPCODE itself, from ODE's sources: its tree of boxes, built as in ODE. It searches the first pair only, with 6 of the
// 15 axes between boxes, which was the faster setting here; ODE tests all 15.
#include <cstdlib>
#include <cstring>
#include "Opcode.h"
#include "peer.h"
#include <vector>

using namespace Opcode;

namespace {
struct Body {
  std::vector<Point> vertices;
  std::vector<IndexedTriangle> triangles;
  MeshInterface mesh;
  Model model;
};

AABBTreeCollider &collider() {
  static AABBTreeCollider collider = [] {
    AABBTreeCollider c;
    c.SetFirstContact(true);
    c.SetTemporalCoherence(false);
    c.SetFullBoxBoxTest(false);
    c.SetFullPrimBoxTest(true);
    return c;
  }();
  return collider;
}
}  // namespace

const char *peer_version() { return ODE_VERSION; }

void *peer_build(const double *vertices, size_t vertex_count, const uint32_t *triangles, size_t triangle_count) {
  auto *body = new Body;
  body->vertices.reserve(vertex_count);
  for (size_t i = 0; i < vertex_count; i++)
    body->vertices.emplace_back(float(vertices[3 * i]), float(vertices[3 * i + 1]), float(vertices[3 * i + 2]));
  body->triangles.resize(triangle_count);
  std::memcpy(body->triangles.data(), triangles, 3 * sizeof(uint32_t) * triangle_count);
  body->mesh.SetNbTriangles(static_cast<udword>(triangle_count));
  body->mesh.SetNbVertices(static_cast<udword>(vertex_count));
  body->mesh.SetPointers(body->triangles.data(), body->vertices.data());
  body->mesh.SetStrides(sizeof(IndexedTriangle), sizeof(Point));
  body->mesh.SetSingle(true);
  const BuildSettings settings(SPLIT_BEST_AXIS | SPLIT_SPLATTER_POINTS | SPLIT_GEOM_CENTER);
  body->model.Build(OPCODECREATE(&body->mesh, settings, true, false));
  return body;
}

void peer_free(void *body) { delete static_cast<Body *>(body); }

size_t peer_bytes(const void *handle) {
  auto *body = static_cast<const Body *>(handle);
  return sizeof(Body) + body->model.GetUsedBytes() + body->vertices.size() * sizeof(Point) +
         body->triangles.size() * sizeof(IndexedTriangle);
}

bool peer_collide(void *a, void *b, const Rows &m) {
  Matrix4x4 pose, identity;
  identity.Identity();
  pose.Set(float(m[0]), float(m[4]), float(m[8]), 0, float(m[1]), float(m[5]), float(m[9]), 0,  //
           float(m[2]), float(m[6]), float(m[10]), 0, float(m[3]), float(m[7]), float(m[11]), 1);
  BVTCache cache;
  cache.Model0 = &static_cast<Body *>(a)->model;
  cache.Model1 = &static_cast<Body *>(b)->model;
  collider().Collide(cache, &pose, &identity);
  return collider().GetContactStatus();
}
