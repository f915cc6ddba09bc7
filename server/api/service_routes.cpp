#include "server/api/service_routes.h"

#include "scene/import/sandbox/jail.h"
#include "server/api/frames.h"
#include "server/api/job_routes.h"
#include "server/api/route_table.h"
#include "server/api/scene_json.h"
#include "server/base/build_id.h"
#include "server/jobs/comparisons.h"
#include "server/scenes/shader_cache.h"
#include "server/service.h"

#include <nlohmann/json.hpp>

namespace clerestory {
namespace {

using nlohmann::ordered_json;

Answer jsonAnswer(const ordered_json& json) {
    return {.type = "application/json",
            .body = json.dump(-1, ' ', false, ordered_json::error_handler_t::replace)};
}

Answer listScenes(Service& service, const Call&) {
    ordered_json list = ordered_json::array();
    for (const SceneStatus& status : service.library().all()) {
        list.push_back(sceneSummary(status, status.id == service.library().defaultId()));
    }
    return jsonAnswer({{"scenes", std::move(list)}});
}

Answer describeScene(Service& service, const Call& call) {
    const std::string id = call.path.substr(call.path.rfind('/') + 1);
    const SceneStatus status = service.library().find(id);
    ordered_json json = sceneDetails(status, status.id == service.library().defaultId());
    if (status.state == SceneState::ready) {
        const WarmUps::Progress p = service.library().warmUp(id);
        json["shaders"] = {{"compiled", p.done}, {"total", p.total}, {"finished", p.finished}};
    }
    return jsonAnswer(json);
}

Answer removeScene(Service& service, const Call& call) {
    service.library().remove(call.path.substr(call.path.rfind('/') + 1));
    return {.status = 204};
}

Answer describeRenderer(Service& service, const Call&) {
    const RendererIdentity& id = service.queue().identity();
    const Config& config = service.config();
    const JailSupport jail = jailSupport();
    const UploadOptions& uploads = config.scenes.uploads;
    const CompileTotals compiled = service.queue().compileTotals();
    return jsonAnswer(
        {{"vendor", id.vendor},
         {"renderer", id.renderer},
         {"version", id.version},
         {"shadingLanguage", id.shadingLanguage},
         {"platform", id.platform},
         {"software", id.software},
         {"clipControl", id.clipControl},
         {"timerQueriesTrusted", id.timerQueriesTrusted},
         {"tellsOfResets", id.tellsOfResets},
         {"maxSamples", id.maxSamples},
         {"maxAnisotropy", id.maxAnisotropy},
         {"maxTextureSize", id.maxTextureSize},
         {"shaders",
          {{"programs", compiled.programs},
           {"pipelines", compiled.pipelines},
           {"compileSeconds", compiled.seconds},
           {"optimized", !(id.software && compilesFast())}}},
         {"environments", service.library().environmentNames()},
         {"threads", std::thread::hardware_concurrency()},
         {"limits",
          {{"edge", kMaxEdge},
           {"pixels", kMaxPixels},
           {"bodyBytes", config.http.limits.bodyBytes},
           {"sequenceBytes", config.sequenceBytes},
           {"uploadBytes", uploads.folder.empty() ? 0 : uploads.limits.fileBytes},
           {"queue", config.queue},
           {"deadlineSeconds", config.deadlineSeconds}}},
         {"importer", {{"landlock", jail.landlock}, {"systemCallFilter", jail.systemCallFilter}}},
         {"program", {{"version", versionText()}, {"build", buildId()}}}});
}

Answer readiness(Service& service, const Call&) {
    if (!service.queue().hasRoom()) throw RequestError(notReady("The queue is full."));
    const SceneState first = service.library().find(service.library().defaultId()).state;
    if (first != SceneState::ready) {
        throw RequestError(notReady("The default scene is " + std::string(nameOf(first)) + "."));
    }
    if (!service.library().defaultIsWarm()) {
        const WarmUps::Progress p = service.library().warmUp(service.library().defaultId());
        throw RequestError(
            notReady("Shaders of the default scene are being compiled: " + std::to_string(p.done) +
                     " of " + std::to_string(p.total) + " programs."));
    }
    service.checkCanary();
    return jsonAnswer({{"status", "ready"}});
}

// The front adds what it counts itself.
Answer metrics(Service& service, const Call&) {
    return {.type = kMetricsType,
            .body = service.metrics().text(service.queue().depth(), service.queue().compileTotals(),
                                           service.library().totals())};
}

constexpr Route<Service> kRoutes[] = {
    {"/v1/frames", "POST", postFrame},
    {"/v1/frames", "GET", getFrame},
    {"/v1/plans", "POST", postPlan},
    {"/v1/comparisons", "POST", postComparison},
    {"/v1/jobs/{id}", "GET", getJob},
    {"/v1/jobs/{id}", "DELETE", cancelJob},
    {"/v1/jobs/{id}/pictures/{number}", "GET", getJobPicture},
    {"/v1/scenes", "GET", listScenes},
    {"/v1/scenes/{id}", "GET", describeScene},
    {"/v1/scenes/{id}", "DELETE", removeScene},
    {"/v1/renderer", "GET", describeRenderer},
    {"/readyz", "GET", readiness},
    {"/metrics", "GET", metrics},
};

}  // namespace

Answer answerTo(Service& service, const Call& call) {
    std::string route;
    Answer answer = guarded(call, [&] {
        auto found = routed<Service>(kRoutes, service, call, route);
        if (!found) throw RequestError(notFound("There is nothing at this path."));
        return *std::move(found);
    });
    answer.route = route;
    return answer;
}

std::vector<std::pair<std::string, std::string>> serviceRoutePaths() {
    std::vector<std::pair<std::string, std::string>> paths;
    for (const auto& row : kRoutes) paths.emplace_back(row.path, row.method);
    return paths;
}

}  // namespace clerestory
