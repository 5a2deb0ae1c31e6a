// nanoflann's k-d tree over points in f32. It does not use `peer.h`: it searches neighbours, all queries in one call,
// and has no bodies. -ffp-contract=off: squared distances are rounded as in simdop, so that the answers are the same.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <nanoflann.hpp>
#include <vector>

namespace {
struct Points {
  std::vector<float> at;
  size_t kdtree_get_point_count() const { return at.size() / 3; }
  float kdtree_get_pt(size_t i, size_t axis) const { return at[3 * i + axis]; }
  template <class Box>
  bool kdtree_get_bbox(Box &) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Points>, Points, 3, uint32_t>;

struct Cloud {
  Points points;
  Tree tree;
  Cloud(const float *at, size_t count, size_t leaf)
      : points{std::vector<float>(at, at + 3 * count)},
        tree(3, points, nanoflann::KDTreeSingleIndexAdaptorParams(leaf)) {}
};

// nanoflann accepts distances below the limit; simdop also accepts equal ones. The next float makes them agree.
float beyond(float radius) { return std::nextafter(radius * radius, std::numeric_limits<float>::infinity()); }

struct Count {
  using DistanceType = float;
  float square;
  uint32_t found = 0;
  bool full() const { return true; }
  bool addPoint(float, uint32_t) {
    found++;
    return true;
  }
  float worstDist() const { return square; }
};

struct Fill {
  using DistanceType = float;
  float square;
  uint32_t *next, *end;
  bool full() const { return true; }
  bool addPoint(float, uint32_t index) {
    if (next == end) return false;
    *next++ = index;
    return true;
  }
  float worstDist() const { return square; }
};

struct List {
  uint32_t start, count;
};
}  // namespace

extern "C" {
const char *peer_version() { return "1.4.3"; }

void *peer_cloud(const float *points, size_t count, size_t leaf) { return new Cloud(points, count, leaf); }

void peer_cloud_free(void *cloud) { delete static_cast<Cloud *>(cloud); }

// The points in the order of the tree's leaves.
void peer_cloud_order(const void *cloud, uint32_t *order) {
  const auto &of = static_cast<const Cloud *>(cloud)->tree.vAcc;
  std::copy(of.begin(), of.end(), order);
}

// Queries in this order, each with its radius, or all with the first (stride 0).
void peer_cloud_count(const void *cloud, const float *queries, const uint32_t *order, size_t count,
                      const float *radii, size_t stride, uint32_t *counts) {
  const Tree &tree = static_cast<const Cloud *>(cloud)->tree;
  for (size_t i = 0; i < count; i++) {
    const uint32_t query = order[i];
    Count found{beyond(radii[stride * query])};
    tree.findNeighbors(found, queries + 3 * query, nanoflann::SearchParams());
    counts[query] = found.found;
  }
}

void peer_cloud_fill(const void *cloud, const float *queries, const uint32_t *order, size_t count,
                     const float *radii, size_t stride, List *lists, uint32_t *indices, size_t room) {
  const Tree &tree = static_cast<const Cloud *>(cloud)->tree;
  Fill found{0, indices, indices + room};
  for (size_t i = 0; i < count; i++) {
    const uint32_t query = order[i];
    const uint32_t *start = found.next;
    found.square = beyond(radii[stride * query]);
    tree.findNeighbors(found, queries + 3 * query, nanoflann::SearchParams());
    lists[query] = {uint32_t(start - indices), uint32_t(found.next - start)};
  }
}

void peer_cloud_nearest(const void *cloud, const float *queries, const uint32_t *order, size_t count, size_t k,
                        uint32_t *indices, float *squares) {
  const Tree &tree = static_cast<const Cloud *>(cloud)->tree;
  for (size_t i = 0; i < count; i++) {
    const uint32_t query = order[i];
    tree.knnSearch(queries + 3 * query, k, indices + k * query, squares + k * query);
  }
}
}
