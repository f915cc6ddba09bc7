// Classes of surfaces by the names of their nodes, for images that label them.
//
//     classesOf(scene, {{"car", "vehicle*"}, {"tree", "oak*"}, {"tree", "*pine*"}})  // 1 and 2
#pragma once

#include "scene/fields.h"
#include "scene/scene.h"

#include <concepts>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

namespace clerestory {

// What is at or below a node whose name matches the pattern belongs to the class `name`.
struct ClassPattern {
    std::string name;
    std::string pattern;  // see matchesName()
};

inline constexpr std::size_t kMaxClassPatterns = 256;

template <class C, class V>
requires std::same_as<std::remove_const_t<C>, ClassPattern>
void fields(C& c, V&& visit) {
    visit("name", c.name, Required{Text{256}},
          "name of the class; entries with the same name form one class");
    visit("pattern", c.pattern, Required{Text{256}},
          "name of the nodes at or below which surfaces belong to the class; * matches any text");
}

// An error for each pattern that no node of the scene matches. `pointer` is the JSON Pointer of the
// list.
std::vector<FieldError> problems(const Scene& scene, const std::vector<ClassPattern>& classes,
                                 const std::string& pointer = "/output/classes");

// The different names of the list, in their order: that of class n is the n-th one, from 1.
std::vector<std::string> classNames(const std::vector<ClassPattern>& classes);

// For each instance its class, by the first pattern that matches its node or an ancestor: the
// different names of the list count from 1 in their order; 0: no pattern matches.
std::vector<std::uint32_t> classesOf(const Scene& scene, const std::vector<ClassPattern>& classes);

}  // namespace clerestory
