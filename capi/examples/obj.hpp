/*
 * OBJ files for the programs in this folder and in ompl/: vertices, and faces with one number per corner.
 */
#ifndef SIMDOP_EXAMPLES_OBJ_HPP
#define SIMDOP_EXAMPLES_OBJ_HPP

#include <fstream>
#include <iterator>
#include <simdop.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

inline std::string text_of(const std::string &path) {
    std::ifstream file(path);
    if (!file) {
        throw std::runtime_error(path + " cannot be read");
    }
    return std::string(std::istreambuf_iterator<char>(file), {});
}

struct triangles {
    std::vector<simdop::vec3> vertices;
    std::vector<simdop::triangle> faces;
};

/* The vertices and faces of an OBJ file. */
inline triangles read_obj(const std::string &path, const double *scale) {
    triangles mesh;
    std::istringstream text(text_of(path));
    for (std::string line; std::getline(text, line);) {
        std::istringstream words(line);
        std::string word;
        words >> word;
        if (word == "v") {
            simdop::vec3 v{};
            words >> v[0] >> v[1] >> v[2];
            mesh.vertices.push_back({v[0] * scale[0], v[1] * scale[1], v[2] * scale[2]});
        } else if (word == "f") {
            std::vector<std::uint32_t> corners;
            for (std::string corner; words >> corner;) {
                corners.push_back(static_cast<std::uint32_t>(std::stoul(corner) - 1));
            }
            for (std::size_t i = 2; i < corners.size(); i++) {
                mesh.faces.push_back({corners[0], corners[i - 1], corners[i]});
            }
        }
    }
    return mesh;
}

/* A solid if the mesh is closed, else a surface. */
inline simdop::body body_of(const triangles &mesh) {
    try {
        return simdop::body::solid({mesh.vertices, mesh.faces});
    } catch (const simdop::error &) {
        return simdop::body::surface({mesh.vertices, mesh.faces});
    }
}

#endif
