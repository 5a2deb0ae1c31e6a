// FCL: trees of the volume that -DVOLUME names (OBB, OBBRSS), as its package compiles them.
#include "peer.h"
#include <fcl/config.h>
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

using Volume = fcl::VOLUME<double>;
using Model = fcl::BVHModel<Volume>;

const char *peer_version() { return FCL_VERSION; }

void *peer_build(const double *vertices, size_t vertex_count, const uint32_t *triangles, size_t triangle_count) {
  std::vector<fcl::Vector3d> points;
  for (size_t i = 0; i < vertex_count; i++) points.emplace_back(vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2]);
  std::vector<fcl::Triangle> faces;
  for (size_t i = 0; i < triangle_count; i++) faces.emplace_back(triangles[3 * i], triangles[3 * i + 1], triangles[3 * i + 2]);
  auto *model = new Model;
  model->beginModel(static_cast<int>(triangle_count), static_cast<int>(vertex_count));
  model->addSubModel(points, faces);
  model->endModel();
  return model;
}

void peer_free(void *body) { delete static_cast<Model *>(body); }

size_t peer_bytes(const void *body) {
  auto *model = static_cast<const Model *>(body);
  return sizeof(Model) + model->getNumBVs() * sizeof(fcl::BVNode<Volume>) + model->num_vertices * sizeof(fcl::Vector3d) +
         model->num_tris * (sizeof(fcl::Triangle) + sizeof(unsigned int));
}

static fcl::Transform3d transform(const Rows &m) {
  fcl::Transform3d pose = fcl::Transform3d::Identity();
  pose.linear() << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
  pose.translation() << m[3], m[7], m[11];
  return pose;
}

bool peer_collide(void *a, void *b, const Rows &rows) {
  const fcl::CollisionRequestd request(1, false);
  fcl::CollisionResultd result;
  fcl::collide(static_cast<Model *>(a), transform(rows), static_cast<Model *>(b), fcl::Transform3d::Identity(), request, result);
  return result.isCollision();
}

#ifdef DISTANCES
double peer_distance(void *a, void *b, const Rows &rows) {
  const fcl::DistanceRequestd request(true);
  fcl::DistanceResultd result;
  fcl::distance(static_cast<Model *>(a), transform(rows), static_cast<Model *>(b), fcl::Transform3d::Identity(), request, result);
  return result.min_distance;
}
#endif
