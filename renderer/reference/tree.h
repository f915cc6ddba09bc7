// Embree's hierarchy over the triangles of a World: with embree.h and tree.cpp all that knows
// Embree here.
#pragma once

#include "reference/embree.h"
#include "reference/world.h"

namespace clerestory::reference {

struct World::Tree {
    explicit Tree(const World& world);
    ~Tree();
    Tree(const Tree&) = delete;
    Tree& operator=(const Tree&) = delete;

    std::optional<Hit> nearest(const Ray& ray) const;
    bool blocked(const Ray& ray) const;

private:
    const World& world_;
    RTCDevice device_ = nullptr;
    RTCScene scene_ = nullptr;
};

}  // namespace clerestory::reference
