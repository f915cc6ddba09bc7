// FrameRequest and FramePlan -> JSON.
#include "plan/graph/work.h"
#include "plan/visibility/view.h"
#include "scene/fields.h"
#include "server/api/frame_json.h"

#include <nlohmann/json.hpp>

namespace clerestory {
namespace {

using nlohmann::ordered_json;
using namespace field;

template <class S>
ordered_json written(const S& value);

ordered_json member(const std::string& value, const Text&) {
    return value;
}
ordered_json member(bool value, const Flag&) {
    return value;
}
template <class E>
ordered_json member(E value, const Choice<E>& choice) {
    return std::string(wordFor(choice, value));
}
template <class T>
ordered_json member(const T& value, const Range& range);
ordered_json member(const Quaternion& value, const Rotation&) {
    return ordered_json(value);
}
template <class E, std::size_t N>
ordered_json member(const std::variant<E, std::array<double, N>>& value,
                    const ChoiceOrNumbers<E>& kind) {
    if (const E* word = std::get_if<E>(&value)) return member(*word, kind.choice);
    return member(std::get<1>(value), kind.range);
}
template <class S>
ordered_json member(const S& value, const Nested&) {
    return written(value);
}
template <class S>
ordered_json member(const S& value, const NestedPreset&) {
    return written(value);
}
template <class S>
ordered_json member(const std::vector<S>& values, const NestedList&) {
    ordered_json list = ordered_json::array();
    for (const S& value : values) list.push_back(written(value));
    return list;
}
ordered_json member(const PlacedScenes& value, const TextOrList& kind) {
    if (value.parts.empty()) return value.id;
    return member(value.parts, NestedList{kind.maxItems});
}
template <class S>
ordered_json member(const std::vector<S>& values, const NestedPresetList&) {
    return member(values, NestedList{});
}
// `type` comes first.
template <class... S>
ordered_json member(const std::variant<S...>& value, const NestedUnion&) {
    return std::visit(
        [](const auto& held) {
            ordered_json json = {{"type", std::decay_t<decltype(held)>::kType}};
            json.update(written(held));
            return json;
        },
        value);
}
template <class... S>
ordered_json member(const std::vector<std::variant<S...>>& values, const NestedUnionList& list) {
    ordered_json json = ordered_json::array();
    for (const auto& value : values) json.push_back(member(value, NestedUnion{list.name}));
    return json;
}
template <class T, class K>
ordered_json member(const T& value, const Required<K>& required) {
    return member(value, required.kind);
}
template <class T>
ordered_json member(const T& value, const Range&) {
    if constexpr (components<T> == 1) {
        return value;
    } else {
        ordered_json list = ordered_json::array();
        for (std::size_t i = 0; i < components<T>; ++i) list.push_back(value[static_cast<int>(i)]);
        return list;
    }
}

template <class S>
ordered_json written(const S& value) {
    ordered_json json = ordered_json::object();
    S copy = value;  // the field tables need mutable values
    fields(copy, [&](const char* name, const auto& held, const auto& kind, const char*) {
        if (const auto* inner = valueOf(held)) json[name] = member(*inner, kind);
    });
    return json;
}

ordered_json numbers(const double* first, std::size_t count) {
    ordered_json list = ordered_json::array();
    for (std::size_t i = 0; i < count; ++i) list.push_back(first[i]);
    return list;
}

ordered_json viewJson(const View& view) {
    return {{"viewFromWorld", numbers(&view.viewFromWorld[0][0], 16)},
            {"clipFromView", numbers(&view.clipFromView[0][0], 16)},
            {"eye", numbers(&view.eye[0], 3)},
            {"znear", view.znear},
            {"orthographic", view.orthographic},
            {"mirrored", view.mirrored}};
}

// Null for the view as a whole.
ordered_json subjectJson(const Subject& subject) {
    if (subject.kind == Subject::Kind::view) return nullptr;
    ordered_json json = {{"kind", nameOf(subject.kind)}, {"name", subject.name}};
    if (subject.kind == Subject::Kind::filter) json["index"] = subject.index;
    return json;
}

ordered_json decisionJson(const Decision& decision) {
    ordered_json json = {{"name", decision.name},
                         {"subject", subjectJson(decision.subject)},
                         {"effect", nameOf(decision.effect)},
                         {"taken", nameOf(decision.taken)},
                         {"reason", decision.reason}};
    auto& candidates = json["candidates"] = ordered_json::array();
    for (const Candidate& c : decision.candidates) {
        candidates.push_back(
            {{"method", nameOf(c.method)}, {"milliseconds", c.milliseconds}, {"error", c.error}});
    }
    return json;
}

// The subject of the passes that draw the target; of a resident one, that of its omission.
Subject subjectOf(const FramePlan& plan, const std::string& target) {
    for (const Pass& pass : plan.passes) {
        if (pass.target != kNoTarget && plan.targets[pass.target].name == target) {
            return pass.subject;
        }
    }
    for (const Skipped& skipped : plan.skipped) {
        if (skipped.name == target) return skipped.subject;
    }
    return {};
}

ordered_json passJson(const FramePlan& plan, const Pass& pass) {
    const PlanTotals t = totals(pass);
    ordered_json json = {{"kind", pass.kind()},
                         {"name", pass.name},
                         {"subject", subjectJson(pass.subject)},
                         {"effect", nameOf(pass.effect)},
                         {"generation", pass.generation},
                         {"views", t.views}};
    if (pass.target < plan.targets.size()) {
        const TargetSpec& target = plan.targets[pass.target];
        json["target"] = target.name;
        json["width"] = target.width;
        json["height"] = target.height;
        json["format"] = nameOf(target.format);
    }
    if (const auto* work = std::get_if<Supersampling>(&pass.work)) json["samples"] = work->samples;
    json["draws"] = t.draws;
    json["triangles"] = t.triangles;
    auto& reads = json["reads"] = ordered_json::array();
    for (const TargetId id : pass.reads()) {
        if (id < plan.targets.size()) reads.push_back(plan.targets[id].name);
    }
    json["reason"] = pass.reason;
    auto& matrices = json["viewMatrices"] = ordered_json::array();
    if (const View* view = pass.view()) matrices.push_back(viewJson(*view));
    return json;
}

}  // namespace

ordered_json accuracyJson(const Accuracy& accuracy) {
    return written(accuracy);
}

ordered_json cameraJson(const CameraRequest& camera) {
    return written(camera);
}

std::string jsonText(const ordered_json& json, int indent) {
    return json.dump(indent, ' ', false, ordered_json::error_handler_t::replace);
}

std::string canonicalText(const FrameRequest& request) {
    return jsonText(written(request));
}

std::optional<FrameCamera> cameraOf(const FramePlan& plan) {
    const View* view = frameView(plan);
    if (view == nullptr) return std::nullopt;
    FrameCamera camera{.width = plan.width, .height = plan.height, .znear = view->znear};
    // The inverse of a rotation is its transpose; + 0.0 removes the sign of zeros.
    camera.cameraToWorld = glm::transpose(glm::dmat3(view->viewFromWorld)) + glm::dmat3(0.0);
    camera.cameraToWorld[3] = glm::dvec4(view->eye, 1.0);
    if (plan.lens) {
        camera.lens = plan.lens->lens.model;
        const bool hasIntrinsics = std::holds_alternative<PerspectiveLens>(camera.lens) ||
                                   std::holds_alternative<FisheyeLens>(camera.lens);
        if (hasIntrinsics) camera.intrinsics = plan.lens->lens.intrinsics;
        return camera;
    }
    camera.clipFromView = view->clipFromView;
    if (view->orthographic) {
        camera.lens = OrthographicLens{2.0 / view->clipFromView[1][1]};
    } else {
        camera.intrinsics = lensOf(view->clipFromView, plan.width, plan.height);
    }
    return camera;
}

ordered_json cameraJson(const FrameCamera& camera) {
    ordered_json json = {{"cameraToWorld", numbers(&camera.cameraToWorld[0][0], 16)},
                         {"convention", "opengl"},
                         {"width", camera.width},
                         {"height", camera.height},
                         {"znear", camera.znear}};
    if (camera.clipFromView) json["clipFromView"] = numbers(&(*camera.clipFromView)[0][0], 16);
    json["lens"] = member(camera.lens, NestedUnion{});
    if (camera.intrinsics) json["intrinsics"] = written(*camera.intrinsics);
    return json;
}

ordered_json lightJson(const LightProgress& light) {
    ordered_json json = {{"revision", light.revision}, {"share", light.share}};
    if (light.failed) json["failed"] = true;
    return json;
}

ordered_json planJson(const FramePlan& plan, const std::vector<PassTime>& times) {
    ordered_json json = {{"passes", ordered_json::array()},
                         {"skipped", ordered_json::array()},
                         {"decisions", ordered_json::array()}};
    for (std::size_t i = 0; i < plan.passes.size(); ++i) {
        ordered_json pass = passJson(plan, plan.passes[i]);
        if (i < times.size()) pass["milliseconds"] = times[i].milliseconds;
        if (i < times.size() && pass["kind"] == "rays") pass["paths"] = times[i].paths;
        json["passes"].push_back(std::move(pass));
    }
    for (const Skipped& skipped : plan.skipped) {
        json["skipped"].push_back({{"name", skipped.name},
                                   {"subject", subjectJson(skipped.subject)},
                                   {"effect", nameOf(skipped.effect)},
                                   {"reason", skipped.reason}});
    }
    for (const Decision& decision : plan.decisions) {
        json["decisions"].push_back(decisionJson(decision));
    }
    if (!plan.composition.empty()) json["composition"] = plan.composition;
    if (const auto camera = cameraOf(plan)) json["camera"] = cameraJson(*camera);
    if (plan.light) json["light"] = lightJson(*plan.light);
    const PlanTotals t = totals(plan);
    json["totals"] = {{"passes", t.passes},
                      {"views", t.views},
                      {"draws", t.draws},
                      {"triangles", t.triangles},
                      {"samples", shadedSamples(plan)}};
    return json;
}

ordered_json mapsJson(const FramePlan& plan, const std::vector<MapPicture>& maps) {
    ordered_json list = ordered_json::array();
    for (const MapPicture& map : maps) {
        list.push_back(
            {{"target", map.target}, {"subject", subjectJson(subjectOf(plan, map.target))}});
    }
    return list;
}

ordered_json healthJson(const std::vector<TargetHealth>& health) {
    std::uint64_t nonFinite = 0, negative = 0;
    ordered_json targets = ordered_json::array();
    for (const TargetHealth& target : health) {
        nonFinite += target.nonFinite;
        negative += target.negative;
        targets.push_back({{"target", target.target},
                           {"texels", target.texels},
                           {"nonFinite", target.nonFinite},
                           {"negative", target.negative}});
    }
    return {{"nonFinite", nonFinite}, {"negative", negative}, {"targets", targets}};
}

}  // namespace clerestory
