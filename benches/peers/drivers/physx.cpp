// PhysX: its overlap of two meshes, ended by the first pair of triangles. Meshes are used as they are, neither welded
// nor cleaned, so that no triangle is lost. Trees are split by surface and not quantized, which on armadillo took 0.2
// to 0.6 of the time of PhysX's default. Leaves have four triangles, the default: with six, unc and panda took down to
// 0.75 of the time, and brain_pia_lh at a gap of 2e-5 took 1.14.
#include "peer.h"
#include <cmath>
#include <cooking/PxCooking.h>
#include <cstdio>
#include <cstdlib>
#include <foundation/PxAllocatorCallback.h>
#include <foundation/PxErrorCallback.h>
#include <foundation/PxFoundation.h>
#include <foundation/PxMat33.h>
#include <foundation/PxPhysicsVersion.h>
#include <geometry/PxMeshQuery.h>
#include <geometry/PxTriangleMesh.h>
#include <geometry/PxTriangleMeshGeometry.h>
#include <malloc.h>
#include <set>
#include <string>
#include <vector>

using namespace physx;

namespace {
// Counts the allocated bytes.
struct Allocator : PxAllocatorCallback {
  size_t kept = 0;
  void *allocate(size_t size, const char *, const char *, int) override {
    void *memory = std::malloc(size);
    kept += malloc_usable_size(memory);
    return memory;
  }
  void deallocate(void *memory) override {
    kept -= malloc_usable_size(memory);
    std::free(memory);
  }
};

struct Errors : PxErrorCallback {
  void reportError(PxErrorCode::Enum, const char *message, const char *, int) override {
    std::fprintf(stderr, "PhysX: %s\n", message);
  }
};

struct Body {
  std::vector<double> vertices;
  std::vector<uint32_t> triangles;
  // In the common unit of all bodies.
  PxTriangleMesh *mesh;
  size_t bytes;
};

// Ends the query at the first pair.
struct FirstPair : PxReportCallback<PxGeomIndexPair> {
  PxGeomIndexPair pair;
  bool found = false;
  FirstPair() : PxReportCallback(&pair, 1) {}
  bool flushResults(PxU32, const PxGeomIndexPair *) override {
    found = true;
    return false;
  }
};

Allocator &allocator() {
  static Allocator allocator;
  return allocator;
}

void start() {
  static Errors errors;
  static PxFoundation *const foundation = PxCreateFoundation(PX_PHYSICS_VERSION, allocator(), errors);
  if (!foundation) std::abort();
}

// PhysX has tolerances in its unit of length: boxes are 2e-4 wider than their contents, and a corner lies in the plane
// of a triangle if its distance times twice the triangle's area is below 1e-6. Its test of two triangles multiplies
// thirteen lengths, which overflows for lengths of about a thousand. In the units of the data, it reported false hits
// near contact: at all poses of a gap of 2e-5 where edges are a hundredth. Hence bodies are scaled by a power of two,
// so that nothing is rounded: edges of the finest body are about 1. With the unit of the coarsest body, a tiny body in
// a room took thousands of times as long.
double unit;
std::set<Body *> bodies;

double own_unit(const Body &body) {
  double sum = 0;
  for (size_t i = 0; i < body.triangles.size(); i += 3) {
    const double *p = &body.vertices[3 * body.triangles[i]], *q = &body.vertices[3 * body.triangles[i + 1]];
    sum += std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
  }
  return sum > 0 ? std::exp2(-std::round(std::log2(3 * sum / double(body.triangles.size())))) : 1;
}

PxVec3 point(double x, double y, double z) { return {float(unit * x), float(unit * y), float(unit * z)}; }
void cook(Body &body) {
  std::vector<PxVec3> points;
  points.reserve(body.vertices.size() / 3);
  for (size_t i = 0; i < body.vertices.size(); i += 3) {
    points.push_back(point(body.vertices[i], body.vertices[i + 1], body.vertices[i + 2]));
  }
  PxTriangleMeshDesc mesh;
  mesh.points.data = points.data();
  mesh.points.stride = sizeof(PxVec3);
  mesh.points.count = static_cast<PxU32>(points.size());
  mesh.triangles.data = body.triangles.data();
  mesh.triangles.stride = 3 * sizeof(uint32_t);
  mesh.triangles.count = static_cast<PxU32>(body.triangles.size() / 3);

  PxCookingParams cooking{PxTolerancesScale()};
  cooking.midphaseDesc = PxMeshMidPhase::eBVH34;
  cooking.midphaseDesc.mBVH34Desc.buildStrategy = PxBVH34BuildStrategy::eSAH;
  cooking.midphaseDesc.mBVH34Desc.quantized = false;
  cooking.meshPreprocessParams |= PxMeshPreprocessingFlag::eDISABLE_CLEAN_MESH;
  cooking.meshPreprocessParams |= PxMeshPreprocessingFlag::eDISABLE_ACTIVE_EDGES_PRECOMPUTE;
  cooking.suppressTriangleMeshRemapTable = true;
  const size_t before = allocator().kept;
  body.mesh = PxCreateTriangleMesh(cooking, mesh, *PxGetStandaloneInsertionCallback());
  if (!body.mesh || body.mesh->getNbTriangles() != mesh.triangles.count) {
    std::fprintf(stderr, "PhysX has not taken all triangles\n");
    std::abort();
  }
  body.bytes = allocator().kept - before;
}
}  // namespace

const char *peer_version() {
  static const std::string version =
      std::to_string(PX_PHYSICS_VERSION_MAJOR) + "." + std::to_string(PX_PHYSICS_VERSION_MINOR) + "." +
      std::to_string(PX_PHYSICS_VERSION_BUGFIX);
  return version.c_str();
}

void *peer_build(const double *vertices, size_t vertex_count, const uint32_t *triangles, size_t triangle_count) {
  start();
  auto *body =
      new Body{{vertices, vertices + 3 * vertex_count}, {triangles, triangles + 3 * triangle_count}, nullptr, 0};
  const double own = own_unit(*body);
  // Bodies of similar size keep their unit.
  if (bodies.empty() || own > 4 * unit) {
    unit = own;
    for (Body *other : bodies) {
      other->mesh->release();
      cook(*other);
    }
  }
  cook(*body);
  bodies.insert(body);
  return body;
}

void peer_free(void *handle) {
  auto *body = static_cast<Body *>(handle);
  bodies.erase(body);
  body->mesh->release();
  delete body;
}

// Without the copy of the mesh that is kept for rescaling.
size_t peer_bytes(const void *handle) { return static_cast<const Body *>(handle)->bytes; }

bool peer_collide(void *a, void *b, const Rows &m) {
  float columns[] = {float(m[0]), float(m[4]), float(m[8]), float(m[1]),
                     float(m[5]), float(m[9]), float(m[2]), float(m[6]), float(m[10])};
  const PxTransform pose(point(m[3], m[7], m[11]), PxQuat(PxMat33(columns)).getNormalized());
  const PxTriangleMeshGeometry moved(static_cast<Body *>(a)->mesh), still(static_cast<Body *>(b)->mesh);
  FirstPair first;
  // Without flags: saving and restoring the processor's rounding mode takes time.
  PxMeshQuery::findOverlapTriangleMesh(first, moved, pose, still, PxTransform(PxIdentity), PxGeometryQueryFlags());
  return first.found;
}
