// A second, independent reader of glTF animations, for tests. Poses of nodes and triangles in world
// space at a time.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace clerestory::test {

// Rows of a 4x4 matrix.
using TruthMatrix = std::array<std::array<double, 4>, 4>;
using TruthPoint = std::array<double, 3>;
using TruthTriangle = std::array<TruthPoint, 3>;

class GltfTruth {
public:
    // .gltf or .glb with embedded buffers, buffer files or data URIs. No sparse accessors.
    explicit GltfTruth(const std::filesystem::path& file);

    std::size_t clipCount() const { return json_["animations"].size(); }
    std::string clipName(std::size_t clip) const;
    double duration(std::size_t clip) const;

    // Goes to a moment of a clip; no looping.
    void pose(std::size_t clip, double time);
    // Numbers of the nodes, depth first from the scene's roots: parents first, children in their
    // order.
    const std::vector<std::size_t>& order() const { return order_; }
    const TruthMatrix& world(std::size_t node) const { return world_.at(node); }
    // All triangles of the scene in the world; those without area in the file are left out.
    std::vector<TruthTriangle> triangles() const;

private:
    using Json = nlohmann::json;
    std::vector<std::vector<double>> accessor(std::size_t number) const;
    std::vector<double> valueAt(const Json& animation, const Json& sampler, bool turns,
                                double time) const;
    void place(std::size_t node, const TruthMatrix& parent);
    void addTriangles(std::size_t node, std::vector<TruthTriangle>& out) const;

    Json json_;
    std::vector<std::string> buffers_;
    std::vector<std::size_t> order_;
    std::map<std::size_t, TruthMatrix> world_;
    std::map<std::size_t, std::map<std::string, std::vector<double>>> moved_;  // by node, path
};

}  // namespace clerestory::test
