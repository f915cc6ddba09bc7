#include "server/api/job_routes.h"

#include "server/base/problem.h"
#include "server/service.h"

#include <nlohmann/json.hpp>

#include <charconv>

namespace clerestory {
namespace {

const std::string kPlace = "/v1/jobs/";

}  // namespace

std::string jobIdIn(std::string_view path) {
    if (!path.starts_with(kPlace)) return "";
    path.remove_prefix(kPlace.size());
    return std::string(path.substr(0, path.find('/')));
}

Answer toldJob(const JobStatus& status) {
    nlohmann::ordered_json json = {
        {"id", status.id}, {"state", nameOf(status.state)}, {"progress", status.progress}};
    if (!status.failure.empty()) json["failure"] = status.failure;
    std::string body = json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    if (status.result) {  // it is JSON already
        body.back() = ',';
        body += "\"result\":" + status.result->json + "}";
    }
    return {.type = "application/json",
            .body = std::move(body),
            .headers = {{"Cache-Control", "no-store"}}};
}

Answer accepted(const JobStatus& status) {
    Answer answer = toldJob(status);
    answer.status = 202;
    answer.headers.emplace_back("Location", kPlace + status.id);
    return answer;
}

Answer getJob(Service& service, const Call& call) {
    return toldJob(service.jobs().find(jobIdIn(call.path)));
}

Answer cancelJob(Service& service, const Call& call) {
    return toldJob(service.jobs().cancel(jobIdIn(call.path)));
}

Answer getJobPicture(Service& service, const Call& call) {
    const JobStatus status = service.jobs().find(jobIdIn(call.path));
    const std::string number = call.path.substr(call.path.rfind('/') + 1);
    std::size_t index = 0;
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), index);
    const bool sound = error == std::errc() && end == number.data() + number.size();
    if (!sound || !status.result || index >= status.result->pictures.size()) {
        throw RequestError(notFound("The job has no such picture, or not yet."));
    }
    const JobPicture& picture = status.result->pictures[index];
    return {.type = picture.type, .body = picture.bytes};
}

}  // namespace clerestory
