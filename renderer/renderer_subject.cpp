// The objects that a request names: scene, composition, pose and environment map.
#include "renderer_state.h"

#include "gl/buffer.h"

#include <algorithm>
#include <set>
#include <stdexcept>

namespace clerestory {
namespace {

template <class Map>
std::string keysOf(const Map& map) {
    std::string keys;
    for (const auto& [key, value] : map) keys += (keys.empty() ? "one of: " : ", ") + key;
    return keys.empty() ? "none is loaded" : keys;
}

}  // namespace

std::shared_ptr<const Pose> Renderer::State::poseOf(const std::shared_ptr<const Scene>& scene,
                                                    std::vector<Index> clips, double time) const {
    if (clips.empty()) time = 0.0;
    const auto found = std::find_if(moments.begin(), moments.end(), [&](const Moment& m) {
        return m.scene == scene && m.clips == clips && m.time == time;
    });
    if (found != moments.end()) {
        moments.splice(moments.begin(), moments, found);
    } else {
        auto pose = std::make_shared<const Pose>(poseAt(*scene, clips, time));
        moments.push_front({scene, std::move(clips), time, std::move(pose)});
        if (moments.size() > kMaxMoments) moments.pop_back();
    }
    return moments.front().pose;
}

bool Renderer::State::hasEnvironment(const std::string& name) const {
    if (environments.contains(name)) return true;
    auto map = builtinEnvironment(name);
    if (!map) return false;
    environments[name] = std::make_shared<const EnvironmentMap>(*std::move(map));
    return true;
}

std::vector<std::string> Renderer::State::environmentNames() const {
    const std::vector<std::string> builtin = builtinEnvironmentNames();
    std::set<std::string> names(builtin.begin(), builtin.end());
    for (const auto& [name, map] : environments) names.insert(name);
    return {names.begin(), names.end()};
}

std::string Renderer::State::environmentList() const {
    std::string list;
    for (const std::string& name : environmentNames()) {
        list += (list.empty() ? "one of: " : ", ") + name;
    }
    return list;
}

const Renderer::State::Loaded& Renderer::State::loaded(const std::string& id,
                                                       const std::string& pointer) const {
    const auto scene = scenes.find(id);
    if (scene != scenes.end()) return scene->second;
    throw InvalidRequest({{pointer, "there is no such scene", keysOf(scenes)}});
}

std::shared_ptr<const Scene> Renderer::State::wholeOf(const FrameRequest& request) {
    if (request.parts.empty()) {
        return loaded(request.scene.empty() ? firstScene : request.scene, "/scene").scene;
    }
    std::vector<FieldError> errors = problems(request.parts);
    std::vector<std::shared_ptr<const Scene>> each;
    for (std::size_t i = 0; i < request.parts.size(); ++i) {
        try {
            const std::string pointer = "/scene/" + std::to_string(i) + "/scene";
            each.push_back(loaded(request.parts[i].scene, pointer).scene);
        } catch (const InvalidRequest& unknown) {
            errors.push_back(unknown.errors().front());
        }
    }
    if (!errors.empty()) throw InvalidRequest(std::move(errors));
    try {
        return compositions.joined(each, request.parts);
    } catch (const std::length_error& tooLarge) {
        throw InvalidRequest({problemOf(tooLarge)});
    }
}

Renderer::State::Subject Renderer::State::subjectOf(const FrameRequest& request) {
    const std::shared_ptr<const Scene> held = wholeOf(request);
    const std::string name = request.environment.map.value_or(held->environment);
    if (!hasEnvironment(name)) {
        throw InvalidRequest(
            {{"/environment/map", "there is no such environment map", environmentList()}});
    }
    std::vector<FieldError> errors = problems(*held, request.overrides);
    for (FieldError& e : problems(*held, request.lights)) errors.push_back(std::move(e));
    for (std::size_t i = 0; i < request.overrides.size(); ++i) {
        const auto& map = request.overrides[i].environmentMap;
        if (map && !map->empty() && !hasEnvironment(*map)) {
            errors.push_back({"/overrides/" + std::to_string(i) + "/environmentMap",
                              "there is no such environment map", environmentList()});
        }
    }
    for (FieldError& e : problems(*held, request.nodes)) errors.push_back(std::move(e));
    for (FieldError& e : problems(*held, request.output.classes)) errors.push_back(std::move(e));
    const auto clips = clipsNamed(*held, request.clip);
    if (!clips) errors.push_back(unknownClip(*held));
    if (!hasVariant(*held, request.variant)) errors.push_back(unknownVariant(*held));
    if (!errors.empty()) throw InvalidRequest(std::move(errors));
    for (const Material& material : held->materials) hasEnvironment(material.environmentMap);
    const std::shared_ptr<const Scene> shown = compositions.composed(held, compositionOf(request));
    const Loaded& first = scenes.at(held->id);
    Subject subject{shown, first.generation, environments.at(name),
                    poseOf(shown, *clips, request.time), first.convex && shown == first.scene};
    if (request.output.channel == Channel::flow && request.output.flow) {
        subject.flowPose = poseOf(shown, *clips, request.output.flow->time);
    }
    return subject;
}

}  // namespace clerestory
