// The channel instances -> JSON.
#include "scene/classes.h"
#include "server/api/frame_json.h"

#include <nlohmann/json.hpp>

#include <span>

namespace clerestory {
namespace {

using nlohmann::ordered_json;

// Null for an empty one.
ordered_json boxJson(const PixelBox& box) {
    if (box.width == 0) return nullptr;
    return {{"x", box.x}, {"y", box.y}, {"width", box.width}, {"height", box.height}};
}

ordered_json entryOf(const LabelledInstance& instance, const std::vector<std::string>& classes) {
    const InstanceExtent& e = instance.extent;
    ordered_json json = {{"objectId", e.instance + 1},
                         {"node", instance.node},
                         {"materialId", instance.materialId},
                         {"classId", instance.classId}};
    if (instance.classId > 0) json["class"] = classes[instance.classId - 1];
    json["worldFromModel"] = std::span(&instance.worldFromModel[0][0], 16);
    json["pixels"] = e.pixels;
    json["amodalPixels"] = e.pixelsAlone;
    json["visibleShare"] = static_cast<double>(e.pixels) / e.pixelsAlone;
    json["box"] = boxJson(e.box);
    json["amodalBox"] = boxJson(e.boxAlone);
    return json;
}

}  // namespace

ordered_json instancesJson(const Frame& frame, const std::vector<ClassPattern>& classes) {
    const std::vector<std::string> names = classNames(classes);
    ordered_json json = {{"width", frame.plan.width},
                         {"height", frame.plan.height},
                         {"classes", names},
                         {"instances", ordered_json::array()}};
    for (const LabelledInstance& instance : frame.instances) {
        json["instances"].push_back(entryOf(instance, names));
    }
    return json;
}

}  // namespace clerestory
