#include "server/api/job_routes.h"

#include "server/api/comparison_json.h"
#include "server/api/frame_json.h"
#include "server/api/frames.h"
#include "server/base/problem.h"

#include <nlohmann/json.hpp>

#include <charconv>

namespace clerestory {
namespace {

using nlohmann::ordered_json;

const std::string kPath = "/v1/jobs/";

// "/v1/jobs/ID..." -> "ID"
std::string jobIdIn(std::string_view path) {
    path.remove_prefix(kPath.size());
    return std::string(path.substr(0, path.find('/')));
}

std::string picturePath(const std::string& job, std::size_t index) {
    return kPath + job + "/pictures/" + std::to_string(index);
}

// The last picture is that of the reference.
ordered_json resultJson(const std::string& job, const JobResult& result) {
    if (const auto* curve = std::get_if<Curve>(&result.value)) return curveJson(*curve);
    const auto* comparison = std::get_if<Comparison>(&result.value);
    if (!comparison) return nullptr;
    std::vector<std::string> links;
    for (std::size_t i = 0; i + 1 < result.pictures.size(); ++i) {
        links.push_back(picturePath(job, i));
    }
    ordered_json json = comparisonJson(*comparison, links);
    if (!links.empty()) json["reference"]["picture"] = picturePath(job, links.size());
    return json;
}

Answer postComparison(const JobRoutes& routes, const Call& call) {
    requireJsonType(call);
    requireQuery(call, false);
    ComparisonRequest request = comparisonRequestFrom(strictJson(call.body));
    const auto parts = routes.frames.requireParts(request.frame);
    const auto scene = routes.frames.requireScene(request.frame.scene);
    request.frame.scene = scene->id;
    // Finds errors that need the scene, such as the name of a camera, before the job starts.
    routes.frames.plan(request.frame, turnOf(routes.frames, call));
    return jobStarted(routes.comparisons.start(request, call.client, call.job));
}

Answer getJob(const JobRoutes& routes, const Call& call) {
    const std::string id = jobIdIn(call.path);
    const auto status = routes.jobs.lookUp(id);
    return status ? jobAnswer(*status) : jobUnknown(id, call.requestId);
}

Answer cancelJob(const JobRoutes& routes, const Call& call) {
    const std::string id = jobIdIn(call.path);
    if (!routes.jobs.lookUp(id)) return jobUnknown(id, call.requestId);
    return jobAnswer(routes.jobs.cancel(id));
}

Answer getJobPicture(const JobRoutes& routes, const Call& call) {
    const std::string id = jobIdIn(call.path);
    const auto status = routes.jobs.lookUp(id);
    if (!status) return jobUnknown(id, call.requestId);
    const std::string number = call.path.substr(call.path.rfind('/') + 1);
    std::size_t index = 0;
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), index);
    const bool sound = error == std::errc() && end == number.data() + number.size();
    if (!sound || !status->result || index >= status->result->pictures.size()) {
        throw RequestError(notFound("The job has no such picture, or not yet."));
    }
    const JobPicture& picture = status->result->pictures[index];
    return {.type = picture.type, .body = picture.bytes};
}

}  // namespace

void addRoutes(Routes& routes, const JobRoutes& components) {
    routes.add("/v1/comparisons", "POST", components, postComparison);
    routes.add("/v1/jobs/{id}", "GET", components, getJob);
    routes.add("/v1/jobs/{id}", "DELETE", components, cancelJob);
    routes.add("/v1/jobs/{id}/pictures/{number}", "GET", components, getJobPicture);
}

Answer jobAnswer(const JobStatus& status) {
    ordered_json json = {
        {"id", status.id}, {"state", nameOf(status.state)}, {"progress", status.progress}};
    if (!status.failure.empty()) json["failure"] = status.failure;
    if (status.result) json["result"] = resultJson(status.id, *status.result);
    return {.type = "application/json",
            .body = jsonText(json),
            .headers = {{"Cache-Control", "no-store"}}};
}

Answer jobStarted(const JobStatus& status) {
    Answer answer = jobAnswer(status);
    answer.status = 202;
    answer.headers.emplace_back("Location", kPath + status.id);
    answer.job = JobEvent{JobEvent::Kind::started, status.id};
    return answer;
}

Answer jobUnknown(const std::string& id, const std::string& requestId) {
    Answer answer =
        problemAnswer(notFound("There is no such job, or its result was discarded."), requestId);
    answer.job = JobEvent{JobEvent::Kind::unknown, id};
    return answer;
}

}  // namespace clerestory
