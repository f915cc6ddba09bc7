#include "server/api/renderer_routes.h"

#include "scene/import/sandbox/jail.h"
#include "server/api/frame_json.h"
#include "server/api/scene_json.h"
#include "server/base/process.h"
#include "server/scenes/shader_cache.h"

#include <nlohmann/json.hpp>

#include <sys/prctl.h>

namespace clerestory {
namespace {

using nlohmann::ordered_json;

Answer jsonAnswer(const ordered_json& json) {
    return {.type = "application/json", .body = jsonText(json)};
}

std::string lastPartOf(const std::string& path) {
    return path.substr(path.rfind('/') + 1);
}

Answer listScenes(const RendererRoutes& routes, const Call&) {
    SceneLibrary& library = routes.library;
    ordered_json list = ordered_json::array();
    for (const SceneStatus& status : library.all()) {
        list.push_back(sceneSummary(status, status.id == library.defaultId()));
    }
    return jsonAnswer({{"scenes", std::move(list)}});
}

Answer describeScene(const RendererRoutes& routes, const Call& call) {
    SceneLibrary& library = routes.library;
    return {.type = "application/json",
            .body = sceneDescription(library, library.find(lastPartOf(call.path)))};
}

Answer removeScene(const RendererRoutes& routes, const Call& call) {
    routes.library.remove(lastPartOf(call.path));
    return {.status = 204};
}

ordered_json mapJson(const MapStatus& map) {
    return {{"name", map.name}, {"title", map.title}, {"source", nameOf(map.source)}};
}

Answer listEnvironments(const RendererRoutes& routes, const Call&) {
    ordered_json list = ordered_json::array();
    for (const MapStatus& map : routes.library.environments().all()) list.push_back(mapJson(map));
    return jsonAnswer({{"environments", std::move(list)}});
}

Answer describeEnvironment(const RendererRoutes& routes, const Call& call) {
    EnvironmentLibrary& environments = routes.library.environments();
    const std::string name = lastPartOf(call.path);
    const auto map = environments.require(name);
    ordered_json json = mapJson(environments.status(name));
    json["faceSize"] = map->faceSize;
    json["meanRadiance"] = map->meanRadiance;
    json["sun"] = map->sun.has_value();
    return jsonAnswer(json);
}

Answer removeEnvironment(const RendererRoutes& routes, const Call& call) {
    routes.library.environments().remove(lastPartOf(call.path));
    return {.status = 204};
}

// Of the process of this renderer, which is confined at its start or not at all
// (server/worker/confinement.h): with --single-process it is the server.
ordered_json confinementJson(const JailSupport& possible) {
    constexpr int kFilterMode = 2;
    const bool isFiltered = prctl(PR_GET_SECCOMP, 0, 0, 0, 0) == kFilterMode &&
                            prctl(PR_GET_NO_NEW_PRIVS, 0, 0, 0, 0) == 1;
    return {{"landlock", isFiltered ? possible.landlock : 0}, {"systemCallFilter", isFiltered}};
}

Answer describeRenderer(const RendererRoutes& routes, const Call&) {
    const RendererIdentity& id = routes.queue.identity();
    const ServerLimits& limits = routes.limits;
    const JailSupport jail = jailSupport();
    const CompileTotals compiled = routes.queue.compileTotals();
    return jsonAnswer(
        {{"vendor", id.vendor},
         {"renderer", id.renderer},
         {"version", id.version},
         {"shadingLanguage", id.shadingLanguage},
         {"platform", id.platform},
         {"device", id.device ? ordered_json(*id.device) : ordered_json(nullptr)},
         {"software", id.software},
         {"clipControl", id.clipControl},
         {"timerQueriesTrusted", id.timerQueriesTrusted},
         {"tellsOfResets", id.tellsOfResets},
         {"maxAnisotropy", id.maxAnisotropy},
         {"maxTextureSize", id.maxTextureSize},
         {"shaders",
          {{"programs", compiled.programs},
           {"pipelines", compiled.pipelines},
           {"compileSeconds", compiled.seconds},
           {"optimized", !(id.software && compilesFast())}}},
         {"environments", routes.library.environments().names()},
         {"threads", std::thread::hardware_concurrency()},
         {"limits",
          {{"edge", kMaxEdge},
           {"pixels", kMaxPixels},
           {"bodyBytes", limits.bodyBytes},
           {"sequenceBytes", limits.sequenceBytes},
           {"uploadBytes", limits.uploadBytes},
           {"frameCacheBytes", limits.frameCacheBytes},
           {"queue", limits.queue},
           {"deadlineSeconds", limits.deadlineSeconds}}},
         {"importer", {{"landlock", jail.landlock}, {"systemCallFilter", jail.systemCallFilter}}},
         {"confinement", confinementJson(jail)},
         {"program", {{"version", versionText()}, {"build", buildId()}}}});
}

Answer readiness(const RendererRoutes& routes, const Call&) {
    SceneLibrary& library = routes.library;
    const SceneState first = library.find(library.defaultId()).state;
    if (first != SceneState::ready) {
        throw RequestError(notReady("The default scene is " + std::string(nameOf(first)) + "."));
    }
    if (!library.defaultIsWarm()) {
        const WarmUps::Progress p = library.warmUp(library.defaultId());
        throw RequestError(
            notReady("Shaders of the default scene are being compiled: " + std::to_string(p.done) +
                     " of " + std::to_string(p.total) + " programs."));
    }
    routes.canary.check();
    return jsonAnswer({{"status", "ready"}});
}

// Of the renderer; the server adds its own (server/api/request_metrics.h).
Answer metrics(const RendererRoutes& routes, const Call&) {
    return {.type = kMetricsType,
            .body = routes.metrics.text({.queueDepth = routes.queue.depth(),
                                         .queue = routes.queue.usage(),
                                         .jobs = routes.jobs.usage(),
                                         .compiled = routes.queue.compileTotals(),
                                         .scenes = routes.library.totals()})};
}

}  // namespace

void addRoutes(Routes& routes, const RendererRoutes& components) {
    routes.add("/v1/scenes", "GET", components, listScenes);
    routes.add("/v1/scenes/{id}", "GET", components, describeScene);
    routes.add("/v1/scenes/{id}", "DELETE", components, removeScene);
    routes.add("/v1/environments", "GET", components, listEnvironments);
    routes.add("/v1/environments/{map}", "GET", components, describeEnvironment);
    routes.add("/v1/environments/{map}", "DELETE", components, removeEnvironment);
    routes.add("/v1/renderer", "GET", components, describeRenderer);
    routes.add("/readyz", "GET", components, readiness);
    routes.add("/metrics", "GET", components, metrics);
}

std::string withRenderers(const std::string& body, const std::vector<RendererSummary>& renderers) {
    ordered_json json = ordered_json::parse(body);
    ordered_json list = ordered_json::array();
    for (const RendererSummary& one : renderers) {
        list.push_back({{"worker", one.worker}, {"warm", one.isWarm}, {"scenes", one.scenes}});
    }
    json["renderers"] = std::move(list);
    return jsonText(json);
}

std::string sceneDescription(SceneLibrary& library, const SceneStatus& status) {
    ordered_json json = sceneDetails(status, status.id == library.defaultId());
    if (status.state == SceneState::ready) {
        const WarmUps::Progress p = library.warmUp(status.id);
        json["shaders"] = {{"compiled", p.done}, {"total", p.total}, {"finished", p.finished}};
        if (status.lightNow) json["light"] = lightJson(status.lightNow());
    }
    return jsonText(json);
}

}  // namespace clerestory
