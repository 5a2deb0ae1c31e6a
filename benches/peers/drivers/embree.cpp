// Embree: rtcCollide finds pairs of triangles whose boxes meet; simdop's exact test decides them. Embree's trees have
// no pose: every query moves A's triangles and refits A's tree, which is part of its time.
#include "peer.h"
#include <algorithm>
#include <cmath>
#include <embree3/rtcore.h>
#include <limits>
#include <string>
#include <vector>

using Triangle = double[3][3];
using TriangleTest = bool (*)(const Triangle &, const Triangle &);

namespace {
TriangleTest meet;

struct Side {
  std::vector<double> vertices;
  const std::vector<uint32_t> *triangles;
  RTCScene scene;
  RTCGeometry geometry;
  void corners(unsigned i, Triangle &out) const {
    for (int c = 0; c < 3; c++) std::copy_n(&vertices[3 * (*triangles)[3 * i + c]], 3, out[c]);
  }
};

struct Body {
  std::vector<double> vertices;
  std::vector<uint32_t> triangles;
  Side moved, still;
};

RTCDevice device() {
  static RTCDevice device = rtcNewDevice("threads=1");
  return device;
}

void bounds(const RTCBoundsFunctionArguments *arguments) {
  Triangle t;
  static_cast<const Side *>(arguments->geometryUserPtr)->corners(arguments->primID, t);
  float low[3], high[3];
  for (int k = 0; k < 3; k++) {
    // Rounded outwards, as the conversion to f32 rounds to nearest.
    low[k] = std::nextafterf(float(std::min({t[0][k], t[1][k], t[2][k]})), -std::numeric_limits<float>::infinity());
    high[k] = std::nextafterf(float(std::max({t[0][k], t[1][k], t[2][k]})), std::numeric_limits<float>::infinity());
  }
  RTCBounds *out = arguments->bounds_o;
  out->lower_x = low[0], out->lower_y = low[1], out->lower_z = low[2];
  out->upper_x = high[0], out->upper_y = high[1], out->upper_z = high[2];
}

void start(Side &side, const Body &body, bool moves) {
  side.vertices = body.vertices;
  side.triangles = &body.triangles;
  side.scene = rtcNewScene(device());
  if (moves) {
    rtcSetSceneFlags(side.scene, RTC_SCENE_FLAG_DYNAMIC);
    // Otherwise a commit rebuilds the tree, which takes 15 times as long.
    rtcSetSceneBuildQuality(side.scene, RTC_BUILD_QUALITY_LOW);
  }
  side.geometry = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(side.geometry, static_cast<unsigned>(body.triangles.size() / 3));
  rtcSetGeometryUserData(side.geometry, &side);
  rtcSetGeometryBoundsFunction(side.geometry, bounds, nullptr);
  rtcSetGeometryBuildQuality(side.geometry, moves ? RTC_BUILD_QUALITY_REFIT : RTC_BUILD_QUALITY_MEDIUM);
  rtcCommitGeometry(side.geometry);
  rtcAttachGeometry(side.scene, side.geometry);
  rtcCommitScene(side.scene);
}

void finish(Side &side) {
  rtcReleaseGeometry(side.geometry);
  rtcReleaseScene(side.scene);
}

struct Search {
  const Side *a, *b;
  bool hit;
};

void pairs(void *pointer, RTCCollision *collisions, unsigned count) {
  auto *search = static_cast<Search *>(pointer);
  // rtcCollide cannot be aborted; after a hit nothing is tested.
  for (unsigned i = 0; i < count && !search->hit; i++) {
    Triangle s, t;
    search->a->corners(collisions[i].primID0, s);
    search->b->corners(collisions[i].primID1, t);
    search->hit = meet(s, t);
  }
}
}  // namespace

extern "C" void peer_triangle_test(TriangleTest test) { meet = test; }

const char *peer_version() {
  static const std::string version =
      std::to_string(rtcGetDeviceProperty(device(), RTC_DEVICE_PROPERTY_VERSION_MAJOR)) + "." +
      std::to_string(rtcGetDeviceProperty(device(), RTC_DEVICE_PROPERTY_VERSION_MINOR)) + "." +
      std::to_string(rtcGetDeviceProperty(device(), RTC_DEVICE_PROPERTY_VERSION_PATCH));
  return version.c_str();
}

void *peer_build(const double *vertices, size_t vertex_count, const uint32_t *triangles, size_t triangle_count) {
  auto *body = new Body{{vertices, vertices + 3 * vertex_count}, {triangles, triangles + 3 * triangle_count}, {}, {}};
  start(body->moved, *body, true);
  start(body->still, *body, false);
  return body;
}

void peer_free(void *handle) {
  auto *body = static_cast<Body *>(handle);
  finish(body->moved);
  finish(body->still);
  delete body;
}

size_t peer_bytes(const void *) { return 0; }

bool peer_collide(void *handle_a, void *handle_b, const Rows &m) {
  auto *a = static_cast<Body *>(handle_a);
  Side &moved = a->moved;
  // Not contracted to fused operations, so that the corners are those of simdop's verdict.
  for (size_t i = 0; i < a->vertices.size(); i += 3) {
    const double *p = &a->vertices[i];
    for (int k = 0; k < 3; k++) {
      moved.vertices[i + k] = ((m[4 * k] * p[0] + m[4 * k + 1] * p[1]) + m[4 * k + 2] * p[2]) + m[4 * k + 3];
    }
  }
  rtcCommitGeometry(moved.geometry);
  rtcCommitScene(moved.scene);
  const Side &still = static_cast<Body *>(handle_b)->still;
  Search search{&moved, &still, false};
  rtcCollide(moved.scene, still.scene, pairs, &search);
  return search.hit;
}
