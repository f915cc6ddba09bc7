#include "scene/classes.h"

#include "scene/name_pattern.h"
#include "scene/spelling.h"

#include <algorithm>
#include <map>

namespace clerestory {
namespace {

// For each node whether its own name matches.
std::vector<bool> matching(const Scene& scene, const std::string& pattern) {
    std::vector<bool> chosen(scene.nodes.size());
    for (std::size_t i = 0; i < chosen.size(); ++i) {
        chosen[i] = matchesName(pattern, scene.nodes[i].name);
    }
    return chosen;
}

// 1 for the first name of the list, then 2 for the next one that differs, and so on.
std::vector<std::uint32_t> idsOf(const std::vector<ClassPattern>& classes) {
    std::map<std::string_view, std::uint32_t> known;
    std::vector<std::uint32_t> ids;
    for (const ClassPattern& c : classes) {
        const auto next = static_cast<std::uint32_t>(known.size() + 1);
        ids.push_back(known.try_emplace(c.name, next).first->second);
    }
    return ids;
}

}  // namespace

std::vector<FieldError> problems(const Scene& scene, const std::vector<ClassPattern>& classes,
                                 const std::string& pointer) {
    std::vector<FieldError> errors;
    const auto names = namesOf(scene.nodes);
    for (std::size_t i = 0; i < classes.size(); ++i) {
        const std::vector<bool> chosen = matching(scene, classes[i].pattern);
        if (std::find(chosen.begin(), chosen.end(), true) != chosen.end()) continue;
        errors.push_back(matchesNoNode(pointer + "/" + std::to_string(i) + "/pattern",
                                       classes[i].pattern, names));
    }
    return errors;
}

std::vector<std::string> classNames(const std::vector<ClassPattern>& classes) {
    std::vector<std::string> names;
    for (const ClassPattern& c : classes) {
        if (std::find(names.begin(), names.end(), c.name) == names.end()) names.push_back(c.name);
    }
    return names;
}

std::vector<std::uint32_t> classesOf(const Scene& scene, const std::vector<ClassPattern>& classes) {
    const std::vector<std::uint32_t> ids = idsOf(classes);
    std::vector<std::uint32_t> ofInstance(scene.instances.size(), 0);
    for (std::size_t c = 0; c < classes.size(); ++c) {
        std::vector<bool> chosen = matching(scene, classes[c].pattern);
        for (std::size_t i = 0; i < chosen.size(); ++i) {
            const Index parent = scene.nodes[i].parent;  // parents come first
            if (parent != kNone && chosen[parent]) chosen[i] = true;
        }
        for (std::size_t i = 0; i < ofInstance.size(); ++i) {
            if (ofInstance[i] == 0 && chosen[scene.instances[i].node]) ofInstance[i] = ids[c];
        }
    }
    return ofInstance;
}

}  // namespace clerestory
