// Coal: trees of the volume that -DVOLUME names, as its wheel compiles them.
#include "peer.h"
#include <coal/BVH/BVH_model.h>
#include <coal/collision.h>
#include <coal/distance.h>

using Model = coal::BVHModel<coal::VOLUME>;

const char *peer_version() { return COAL_VERSION; }

void *peer_build(const double *vertices, size_t vertex_count, const uint32_t *triangles, size_t triangle_count) {
  std::vector<coal::Vec3s> points;
  for (size_t i = 0; i < vertex_count; i++) points.emplace_back(vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2]);
  std::vector<coal::Triangle> faces;
  for (size_t i = 0; i < triangle_count; i++) faces.emplace_back(triangles[3 * i], triangles[3 * i + 1], triangles[3 * i + 2]);
  auto *model = new Model;
  model->beginModel(static_cast<unsigned>(triangle_count), static_cast<unsigned>(vertex_count));
  model->addSubModel(points, faces);
  model->endModel();
  return model;
}

void peer_free(void *body) { delete static_cast<Model *>(body); }

size_t peer_bytes(const void *body) {
  auto *model = static_cast<const Model *>(body);
  return sizeof(Model) + model->getNumBVs() * sizeof(coal::BVNode<coal::VOLUME>) + model->num_vertices * sizeof(coal::Vec3s) +
         model->num_tris * (sizeof(coal::Triangle) + sizeof(unsigned int));
}

static coal::Transform3s transform(const Rows &m) {
  coal::Matrix3s rotation;
  rotation << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
  return coal::Transform3s(rotation, coal::Vec3s(m[3], m[7], m[11]));
}

bool peer_collide(void *a, void *b, const Rows &rows) {
  coal::CollisionRequest request;
  request.num_max_contacts = 1;
  request.enable_contact = false;
  // Nodes that are nearer than this are opened though they are apart, for a better bound of the distance: by default 1e-3, in any unit.
  request.break_distance = 0;
  coal::CollisionResult result;
  coal::collide(static_cast<Model *>(a), transform(rows), static_cast<Model *>(b), coal::Transform3s::Identity(), request, result);
  return result.isCollision();
}

#ifdef DISTANCES
double peer_distance(void *a, void *b, const Rows &rows) {
  const coal::DistanceRequest request;
  coal::DistanceResult result;
  return coal::distance(static_cast<Model *>(a), transform(rows), static_cast<Model *>(b), coal::Transform3s::Identity(), request, result);
}
#endif
