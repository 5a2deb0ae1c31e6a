// ODE: dCollide of two meshes, with at most one contact. It collects all pairs of triangles that its OPCODE finds
// before it makes contacts of them.
#include "peer.h"
#include <ode/ode.h>
#include <vector>

namespace {
struct Body {
  std::vector<float> vertices;
  std::vector<dTriIndex> triangles;
  dTriMeshDataID data;
  dGeomID moved, still;
};

void start() {
  static bool started = (dInitODE2(0), dAllocateODEDataForThread(dAllocateMaskAll), true);
  (void)started;
}
}  // namespace

const char *peer_version() { return ODE_VERSION; }

void *peer_build(const double *vertices, size_t vertex_count, const uint32_t *triangles, size_t triangle_count) {
  start();
  auto *body = new Body;
  body->vertices.assign(vertices, vertices + 3 * vertex_count);
  body->triangles.assign(triangles, triangles + 3 * triangle_count);
  body->data = dGeomTriMeshDataCreate();
  dGeomTriMeshDataBuildSingle(body->data, body->vertices.data(), 3 * sizeof(float), static_cast<int>(vertex_count),
                              body->triangles.data(), static_cast<int>(3 * triangle_count), 3 * sizeof(dTriIndex));
  body->moved = dCreateTriMesh(nullptr, body->data, nullptr, nullptr, nullptr);
  body->still = dCreateTriMesh(nullptr, body->data, nullptr, nullptr, nullptr);
  return body;
}

void peer_free(void *handle) {
  auto *body = static_cast<Body *>(handle);
  dGeomDestroy(body->moved);
  dGeomDestroy(body->still);
  dGeomTriMeshDataDestroy(body->data);
  delete body;
}

size_t peer_bytes(const void *) { return 0; }

bool peer_collide(void *a, void *b, const Rows &m) {
  dGeomID moved = static_cast<Body *>(a)->moved;
  dGeomSetPosition(moved, m[3], m[7], m[11]);
  const dMatrix3 rotation = {m[0], m[1], m[2], 0, m[4], m[5], m[6], 0, m[8], m[9], m[10], 0};
  dGeomSetRotation(moved, rotation);
  dContactGeom contact;
  const int flags = 1 | static_cast<int>(CONTACTS_UNIMPORTANT);
  return dCollide(moved, static_cast<Body *>(b)->still, flags, &contact, sizeof contact) > 0;
}
