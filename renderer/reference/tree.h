// Embree's hierarchy over the triangles of a World: the only file but tree.cpp that knows Embree.
#pragma once

#include "reference/world.h"

#include <embree3/rtcore.h>

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
